#include "services/programs/recording/frame_recorder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/source/recorded_sequence.h"
#include "services/programs/recording/recording.h"
#include "services/programs/recording/recording_files.h"
#include "services/testing/test_path.h"

namespace corbslam::services {

using client_agent::OpenSource;
using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kWidth_px = 64;
constexpr int kHeight_px = 48;
constexpr int64_t kFirst_ns = 1305031102175304123;

Camera SmallCamera() { return {50, 50, 31.5, 23.5, kWidth_px, kHeight_px, 0.1, 4}; }

bool AreSame(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

cv::Mat Noise(int type, int most, int seed) {
  cv::Mat picture(kHeight_px, kWidth_px, type);
  cv::RNG random(static_cast<uint64_t>(seed));
  random.fill(picture, cv::RNG::UNIFORM, 0, most);
  return picture;
}

class FrameRecorderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = TestPath("recording");
    std::filesystem::remove_all(folder_);
    options_.waits = true;
    options_.least_free_bytes = 0;
  }
  void Start(const SensorCalibration& calibration) {
    RecordingHead head;
    head.source = "test";
    head.calibration = calibration;
    auto recorder = FrameRecorder::Start(folder_, head, options_);
    ASSERT_TRUE(recorder.ok()) << recorder.status();
    recorder_ = *std::move(recorder);
  }
  void StartStereo() {
    StereoCalibration calibration;
    calibration.camera = SmallCamera();
    Start(calibration);
  }
  static SensorImages StereoFrame(int i) {
    return {kFirst_ns + i * 50'000'001ll, Noise(CV_8UC1, 256, 2 * i + 1),
            Noise(CV_8UC1, 256, 2 * i + 2)};
  }
  void Track(const SensorImages& images) {
    recorder_->OnFrame(images);
    TrackingResult result;
    result.timestamp_ns = images.timestamp_ns;
    result.state = TrackingState::kTracking;
    recorder_->OnResult(result, 4);
  }
  Recording Read() {
    auto recording = ReadRecording(folder_);
    EXPECT_TRUE(recording.ok()) << recording.status();
    return *std::move(recording);
  }

  std::string folder_;
  RecorderOptions options_;
  std::unique_ptr<FrameRecorder> recorder_;
};

TEST_F(FrameRecorderTest, StereoFramesComeBackAsTheyWereAndClientAgentPlaysThem) {
  StartStereo();
  for (int i = 0; i < 3; ++i) {
    if (i == 2) recorder_->OnNewLocalMap();
    Track(StereoFrame(i));
  }
  ASSERT_TRUE(recorder_->Finish().ok());
  const Recording recording = Read();
  ASSERT_EQ(recording.frames.size(), 3u);
  EXPECT_TRUE(recording.head.finished && recording.notes.empty());
  EXPECT_EQ(recording.head.counts, (RecordedCounts{3, 0, 4, 3}));
  EXPECT_TRUE(recording.frames[2].line.begins_local_map);
  EXPECT_FALSE(recording.frames[1].line.begins_local_map);
  const auto played = OpenSource(SourceOfRecording(folder_, SensorKind::kStereo));
  ASSERT_TRUE(played.ok()) << played.status();
  for (int i = 0; i < 3; ++i) {
    const SensorImages given = StereoFrame(i);
    const auto read = ReadPictures(recording, recording.frames[static_cast<size_t>(i)].line);
    ASSERT_TRUE(read.ok()) << read.status();
    const auto from_source = (*played)->NextImages();
    ASSERT_TRUE(from_source.ok() && from_source->has_value()) << from_source.status();
    for (const SensorImages* back : {&*read, &**from_source}) {
      EXPECT_EQ(back->timestamp_ns, given.timestamp_ns);
      EXPECT_TRUE(AreSame(back->grey, given.grey) && AreSame(back->right, given.right));
    }
  }
}

ImuCalibration SomeImu() {
  ImuCalibration imu;
  imu.imu_from_camera.rotation = Eigen::AngleAxisd(1.0 / 3, Eigen::Vector3d(1, -2, 3).normalized());
  imu.imu_from_camera.translation = {0.06, -0.01, 0.02};
  imu.noise = {1.7e-4, 2e-3, 1.9e-5, 3e-3};
  imu.time_offset_s = 0.01;
  return imu;
}

// Ten samples up to the time of the frame.
ImuSamples MeasuredBefore(int64_t time_ns) {
  ImuSamples samples;
  for (int k = 9; k >= 0; --k) {
    const double value = std::sin(static_cast<double>(time_ns % 1'000'000'007) + k) / 3;
    samples.push_back({time_ns - k * 5'000'000, {value, -value / 7, 0.1}, {value, 9.8, -0.3}});
  }
  return samples;
}

void ExpectEqual(const ImuSamples& a, const ImuSamples& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].timestamp_ns, b[i].timestamp_ns);
    EXPECT_EQ(a[i].angular_velocity_rps, b[i].angular_velocity_rps);
    EXPECT_EQ(a[i].specific_force_mps2, b[i].specific_force_mps2);
  }
}

TEST_F(FrameRecorderTest, WhatAnImuMeasuredComesBackWithItsFrames) {
  StereoCalibration stereo;
  stereo.camera = SmallCamera();
  stereo.imu = SomeImu();
  RgbdCalibration rgbd;
  rgbd.camera = SmallCamera();
  rgbd.imu = SomeImu();
  for (const SensorCalibration& calibration : {SensorCalibration(stereo), SensorCalibration(rgbd),
                                               SensorCalibration(FirstCameraOf(rgbd))}) {
    std::filesystem::remove_all(folder_);
    Start(calibration);
    std::vector<SensorImages> frames;
    for (int i = 0; i < 3; ++i) {
      SensorImages images = StereoFrame(i);
      images.timestamp_ns = kFirst_ns + i * 50'000'000ll;
      images.imu = MeasuredBefore(images.timestamp_ns);
      if (KindOf(calibration) != SensorKind::kStereo) images.right = cv::Mat();
      if (KindOf(calibration) == SensorKind::kRgbd) {
        images.depth = Noise(CV_16UC1, 65536, i + 1);
      }
      frames.push_back(images);
      Track(images);
    }
    ASSERT_TRUE(recorder_->Finish().ok());
    const Recording recording = Read();
    const auto played = OpenSource(SourceOfRecording(folder_, KindOf(calibration)));
    ASSERT_TRUE(played.ok()) << played.status();
    for (size_t i = 0; i < 3; ++i) {
      ExpectEqual(ImuOf(recording, recording.frames[i]), frames[i].imu);
      const auto from_source = (*played)->NextImages();
      ASSERT_TRUE(from_source.ok() && from_source->has_value()) << from_source.status();
      EXPECT_EQ(cv::norm((*from_source)->grey, frames[i].grey, cv::NORM_INF), 0);
      ExpectEqual((*from_source)->imu, frames[i].imu);
    }
    // Samples are by the camera's clock already: the rig does not move them once more.
    const auto imu_of = [](const SensorCalibration& of) {
      return std::visit([](const auto& kind) { return kind.imu; }, of);
    };
    EXPECT_EQ(imu_of(recording.head.calibration)->time_offset_s, 0.01);
    EXPECT_EQ(imu_of(recording.head.calibration)->imu_from_camera.rotation.coeffs(),
              SomeImu().imu_from_camera.rotation.coeffs());
    EXPECT_EQ(imu_of((*played)->calibration())->time_offset_s, 0);
    EXPECT_EQ(imu_of((*played)->calibration())->noise.gyro_walk, 1.9e-5);
    recorder_.reset();
  }
}

TEST_F(FrameRecorderTest, FramesThatAreLeftOutLoseNoSamples) {
  options_.waits = false;
  options_.max_waiting_bytes = 0;
  StereoCalibration calibration;
  calibration.camera = SmallCamera();
  calibration.imu = SomeImu();
  Start(calibration);
  SensorImages images = StereoFrame(0);
  images.imu = MeasuredBefore(images.timestamp_ns);
  Track(images);
  ASSERT_TRUE(recorder_->Finish().ok());
  const Recording recording = Read();
  ASSERT_EQ(recording.frames.size(), 1u);
  EXPECT_TRUE(recording.frames[0].line.pictures.empty());
  ExpectEqual(ImuOf(recording, recording.frames[0]), images.imu);
  // A list that lost its end is told.
  std::filesystem::resize_file(ImuListPath(folder_, SensorKind::kStereo), 400);
  const auto cut = ReadRecording(folder_);
  EXPECT_FALSE(cut.ok());
  EXPECT_THAT(std::string(cut.status().message()), HasSubstr("imu0/data.csv"));
}

TEST_F(FrameRecorderTest, DepthKeepsItsSixteenBitsAndTimesTheirNanoseconds) {
  RgbdCalibration calibration;
  calibration.camera = SmallCamera();
  calibration.depth_units_per_m = 1000;
  calibration.mask = cv::Mat(kHeight_px, kWidth_px, CV_8UC1, 255.0);
  calibration.mask.at<uchar>(3, 4) = 0;
  Start(calibration);
  SensorImages images{kFirst_ns, Noise(CV_8UC1, 256, 1)};
  images.depth = Noise(CV_16UC1, 65536, 2);
  Track(images);
  images.timestamp_ns += 33'333'333;
  Track(images);
  ASSERT_TRUE(recorder_->Finish().ok());
  const Recording recording = Read();
  EXPECT_TRUE(
      AreSame(std::get<RgbdCalibration>(recording.head.calibration).mask, calibration.mask));
  const auto played = OpenSource(SourceOfRecording(folder_, SensorKind::kRgbd));
  ASSERT_TRUE(played.ok()) << played.status();
  const auto& used = std::get<RgbdCalibration>((*played)->calibration());
  EXPECT_EQ(used.depth_units_per_m, 1000);
  EXPECT_TRUE(AreSame(used.mask, calibration.mask));
  const auto first = (*played)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_EQ((*first)->timestamp_ns, kFirst_ns);
  EXPECT_TRUE(AreSame((*first)->depth, images.depth));
}

TEST_F(FrameRecorderTest, WhatWasRecordedBeforeACrashCanBePlayed) {
  StartStereo();
  Track(StereoFrame(0));
  recorder_->OnFrame(StereoFrame(1));
  // The robot crashes in this frame: nothing is finished. The files are read while they are open.
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (absl::Now() < deadline && Read().frames.size() < 2) absl::SleepFor(absl::Milliseconds(5));
  const Recording recording = Read();
  ASSERT_EQ(recording.frames.size(), 2u);
  EXPECT_TRUE(recording.frames[0].result.has_value());
  EXPECT_FALSE(recording.frames[1].result.has_value());
  EXPECT_TRUE(ReadPictures(recording, recording.frames[1].line).ok());
  EXPECT_THAT(recording.notes, Contains(HasSubstr("ended without a word")));
}

TEST_F(FrameRecorderTest, FramesDroppedBeforeACrashAreCounted) {
  StartStereo();
  Track(StereoFrame(0));
  Track(StereoFrame(1));
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  const auto is_whole = [](const Recording& now) {
    return now.frames.size() == 2 && now.frames[1].result.has_value();
  };
  while (absl::Now() < deadline && !is_whole(Read())) absl::SleepFor(absl::Milliseconds(5));
  EXPECT_EQ(Read().head.counts, (RecordedCounts{2, 0, 4, 2}));
}

TEST_F(FrameRecorderTest, APictureThatWasReplacedIsNamed) {
  StartStereo();
  Track(StereoFrame(0));
  Track(StereoFrame(1));
  ASSERT_TRUE(recorder_->Finish().ok());
  const Recording recording = Read();
  const std::vector<std::string> first =
      PicturePaths(folder_, SensorKind::kStereo, recording.frames[0].line.pictures);
  const std::vector<std::string> second =
      PicturePaths(folder_, SensorKind::kStereo, recording.frames[1].line.pictures);
  std::filesystem::copy_file(first[1], second[1],
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_TRUE(ReadPictures(recording, recording.frames[0].line).ok());
  const absl::Status replaced = ReadPictures(recording, recording.frames[1].line).status();
  EXPECT_TRUE(absl::IsDataLoss(replaced)) << replaced;
  EXPECT_THAT(std::string(replaced.message()),
              HasSubstr(second[1] + ": holds another picture than was recorded"));
  // A recording of an older version has no checksums.
  FrameLine older = recording.frames[1].line;
  older.checksums.clear();
  EXPECT_TRUE(ReadPictures(recording, older).ok());
}

// The disk takes nothing, however long the robot tracks: what waits is bounded.
TEST_F(FrameRecorderTest, ADiskThatHangsEndsTheRecordingAndNotTheRobotsMemory) {
  options_.waits = false;
  options_.max_waiting_lines = 50;
  StartStereo();
  Track(StereoFrame(0));
  // A named pipe without a reader takes nothing: the writer hangs in it.
  const SensorImages next = StereoFrame(1);
  const std::string pipe = absl::StrCat(folder_, "/mav0/cam0/data/", next.timestamp_ns, ".png");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (int i = 1; i < 200; ++i) Track(StereoFrame(i));
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  const absl::Status ended = recorder_->Finish();
  close(reader);
  EXPECT_THAT(std::string(ended.message()), HasSubstr("has taken nothing for 50 lines"));
  const Recording recording = Read();
  EXPECT_LE(recording.frames.size(), 2u);
  EXPECT_THAT(recording.notes, Contains(HasSubstr("has taken nothing for")));
}

TEST_F(FrameRecorderTest, FramesThatTheDiskHasNoTimeForAreLeftOutAndCounted) {
  options_.waits = false;
  options_.max_waiting_bytes = 1;  // One frame waits, or is written.
  StartStereo();
  constexpr int kMany = 200;
  for (int i = 0; i < kMany; ++i) Track(StereoFrame(i));
  ASSERT_TRUE(recorder_->Finish().ok());
  const Recording recording = Read();
  ASSERT_EQ(recording.frames.size(), size_t{kMany});
  uint64_t without = 0;
  for (const RecordedFrame& frame : recording.frames) {
    EXPECT_TRUE(frame.result.has_value());
    if (frame.line.pictures.empty()) ++without;
  }
  EXPECT_GT(without, 0u) << "200 frames at once";
  EXPECT_EQ(recording.head.counts.left_out, without);
}

TEST_F(FrameRecorderTest, AtFullPaceTrackingWaitsAndNothingIsLeftOut) {
  options_.max_waiting_bytes = 1;
  StartStereo();
  for (int i = 0; i < 40; ++i) Track(StereoFrame(i));
  ASSERT_TRUE(recorder_->Finish().ok());
  EXPECT_EQ(Read().head.counts, (RecordedCounts{40, 0, 4, 40}));
}

TEST_F(FrameRecorderTest, AFullDiskEndsTheRecordingAndNotTheRobot) {
  options_.least_free_bytes = std::numeric_limits<uint64_t>::max();
  StartStereo();
  for (int i = 0; i < 10; ++i) Track(StereoFrame(i));
  EXPECT_EQ(recorder_->Finish().code(), absl::StatusCode::kResourceExhausted);
  const Recording recording = Read();
  EXPECT_TRUE(recording.head.finished);
  EXPECT_THAT(recording.head.ended, HasSubstr("MiB left"));
  EXPECT_EQ(recording.head.counts, (RecordedCounts{10, 10, 4, 10}));
  EXPECT_TRUE(recording.frames.empty());
}

TEST_F(FrameRecorderTest, AFolderThatGoesAwayEndsTheRecordingAndNotTheRobot) {
  StartStereo();
  std::filesystem::remove_all(folder_ + "/mav0");
  for (int i = 0; i < 3; ++i) Track(StereoFrame(i));
  const absl::Status finished = recorder_->Finish();
  EXPECT_EQ(finished.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(finished.message(), HasSubstr("mav0/cam0/data/"));
}

TEST_F(FrameRecorderTest, TimesThatFallHaveFilesOfTheirOwn) {
  StartStereo();
  Track(StereoFrame(0));
  recorder_->OnNewLocalMap();
  Track(StereoFrame(0));
  ASSERT_TRUE(recorder_->Finish().ok());
  const Recording recording = Read();
  ASSERT_EQ(recording.frames.size(), 2u);
  EXPECT_NE(recording.frames[0].line.pictures, recording.frames[1].line.pictures);
  EXPECT_TRUE(ReadPictures(recording, recording.frames[1].line).ok());
}

}  // namespace
}  // namespace corbslam::services

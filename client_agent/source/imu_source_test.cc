// Tests what recordings with an IMU give: which samples come with which frame.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/lists/imu_list.h"
#include "client_agent/source/recorded_sequence.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int64_t kFrameInterval_ns = 50'000'000;
constexpr int64_t kImuInterval_ns = 5'000'000;
constexpr int64_t kBegin_ns = 1'403'715'273'000'000'000;
constexpr int kFrames = 10;

// The camera's z axis is the body's x axis, and the IMU is turned about z.
constexpr char kCameraYaml[] = R"(%%YAML:1.0
T_BS: {cols: 4, rows: 4, data: [0, 0, 1, 0.1, %g, 0, 0, %g, 0, %g, 0, 0, 0, 0, 0, 1]}
resolution: [40, 30]
camera_model: pinhole
intrinsics: [50, 50, 20, 15]
distortion_model: radtan
distortion_coefficients: [0, 0, 0, 0]
)";
constexpr char kImuYaml[] = R"(#Default imu sensor yaml file
sensor_type: imu
comment: VI-Sensor IMU (ADIS16448)
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, 0.02,
         1.0, 0.0, 0.0, 0.0,
         0.0, 0.0, 1.0, 0.0,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 200
gyroscope_noise_density: 1.6968e-04     # [ rad / s / sqrt(Hz) ]   ( gyro "white noise" )
gyroscope_random_walk: 1.9393e-05
accelerometer_noise_density: 2.0000e-3
accelerometer_random_walk: 3.0000e-3
)";
constexpr char kPlainRig[] =
    "rig: 1\nkind: stereo\nrectified: true\nbaseline_m: 0.11\ncameras:\n"
    "  - {size_px: [40, 30], focal_px: [50, 50], principal_px: [20, 15]}\n"
    "  - {size_px: [40, 30], focal_px: [50, 50], principal_px: [20, 15]}\n";
constexpr char kRigsImu[] =
    "imu:\n  imu_from_camera: [1, 0, 0, 0.05, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
    "  gyro_noise: 0.001\n";

void WriteFile(const std::string& path, const std::string& text) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

void WritePicture(const std::string& path, int level) {
  fs::create_directories(fs::path(path).parent_path());
  cv::imwrite(path, cv::Mat(30, 40, CV_8UC1, cv::Scalar(level)));
}

// Returns a list of `count` samples from `begin_ns` on; each turns by its number in thousandths.
std::string ImuListText(int64_t begin_ns, int count) {
  std::vector<std::string> lines = {kImuHeading};
  for (int i = 0; i < count; ++i) {
    ImuSample sample;
    sample.timestamp_ns = begin_ns + i * kImuInterval_ns;
    sample.angular_velocity_rps = {1e-3 * i, 0.1 * std::sin(i), 0.1 * std::cos(i)};
    sample.specific_force_mps2 = {0.2 * std::sin(3 * i), 9.8 + 0.1 * std::sin(i),
                                  0.1 * std::cos(i)};
    lines.push_back(FormatImuLine(sample));
  }
  return absl::StrJoin(lines, "\n");
}

// Writes a recording in EuRoC's layout, whose IMU begins 12 s before the first frame.
std::string MakeRecording(const std::string& name) {
  const std::string folder = absl::StrCat(::testing::TempDir(), "/imu_source_", name);
  fs::remove_all(folder);
  for (int camera = 0; camera < 2; ++camera) {
    const std::string of_camera = absl::StrCat(folder, "/mav0/cam", camera);
    WriteFile(of_camera + "/sensor.yaml",
              absl::StrFormat(kCameraYaml, -1.0, camera == 0 ? 0.0 : -0.11, -1.0));
    std::string list = "#timestamp [ns],filename\n";
    for (int i = 0; i < kFrames; ++i) {
      const std::string picture = absl::StrCat(kBegin_ns + i * kFrameInterval_ns, ".png");
      WritePicture(of_camera + "/data/" + picture, 20 + i);
      absl::StrAppend(&list, kBegin_ns + i * kFrameInterval_ns, ",", picture, "\n");
    }
    WriteFile(of_camera + "/data.csv", list);
  }
  WriteFile(folder + "/mav0/imu0/sensor.yaml", kImuYaml);
  WriteFile(folder + "/mav0/imu0/data.csv",
            ImuListText(kBegin_ns - 12'000'000'000 + 2'000'000, 2600));
  return folder;
}

std::optional<ImuCalibration> ImuOf(const SensorCalibration& calibration) {
  return std::visit([](const auto& kind) { return kind.imu; }, calibration);
}

std::vector<SensorImages> PlayAll(const std::string& spec) {
  const auto source = OpenSource(spec);
  EXPECT_TRUE(source.ok()) << source.status();
  std::vector<SensorImages> frames;
  while (source.ok()) {
    auto images = (*source)->NextImages();
    EXPECT_TRUE(images.ok()) << images.status();
    if (!images.ok() || !images->has_value()) return frames;
    frames.push_back(**std::move(images));
  }
  return frames;
}

std::vector<size_t> SampleCounts(const std::vector<SensorImages>& frames) {
  std::vector<size_t> counts;
  for (const SensorImages& frame : frames) counts.push_back(frame.imu.size());
  return counts;
}

// Expects every sample from the first to the last frame to come once, none twice, each with the
// frame that is told, up to the first behind it.
void ExpectWhole(const std::vector<SensorImages>& frames) {
  int64_t before_ns = 0;
  for (const SensorImages& frame : frames) {
    for (const ImuSample& sample : frame.imu) {
      if (before_ns != 0) {
        EXPECT_EQ(sample.timestamp_ns - before_ns, kImuInterval_ns);
      }
      before_ns = sample.timestamp_ns;
    }
    EXPECT_GE(before_ns, frame.timestamp_ns);
    EXPECT_LT(before_ns, frame.timestamp_ns + kImuInterval_ns);
  }
}

absl::Status StatusOf(const std::string& spec) { return OpenSource(spec).status(); }

std::string MessageOf(const std::string& spec) { return std::string(StatusOf(spec).message()); }

std::unique_ptr<FrameReader> ReaderOf(const std::string& spec) {
  auto reader = OpenReader(*ParseSourceSpec(spec));
  EXPECT_TRUE(reader.ok()) << reader.status();
  return reader.ok() ? *std::move(reader) : nullptr;
}

TEST(ImuSourceTest, EachFrameHasWhatWasMeasuredSinceTheOneBefore) {
  const std::string folder = MakeRecording("plain");
  const auto frames = PlayAll("euroc:" + folder);
  ASSERT_EQ(frames.size(), 10u);
  // Ten seconds before the first: what is older says nothing of it.
  EXPECT_THAT(SampleCounts(frames), ElementsAre(2001, 10, 10, 10, 10, 10, 10, 10, 10, 10));
  ExpectWhole(frames);
}

TEST(ImuSourceTest, TheRecordingSaysWhereTheImuSits) {
  const auto reader = ReaderOf("euroc:" + MakeRecording("place"));
  const auto imu = ImuOf(reader->calibration());
  ASSERT_TRUE(imu.has_value());
  EXPECT_EQ(imu->noise.gyro, 1.6968e-04);
  EXPECT_EQ(imu->noise.gyro_walk, 1.9393e-05);
  EXPECT_EQ(imu->noise.accel, 2e-3);
  EXPECT_EQ(imu->noise.accel_walk, 3e-3);
  EXPECT_EQ(imu->rate_hz, 200);
  // The camera looks along the body's x axis, which is the IMU's -y axis.
  EXPECT_LT(
      (imu->imu_from_camera.rotation * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitY()).norm(),
      1e-9);
  EXPECT_LT((imu->imu_from_camera.translation - Eigen::Vector3d(0, -0.08, 0)).norm(), 1e-9);
  EXPECT_THAT(reader->description().imu, HasSubstr("200 Hz, 2600 samples from 1403715261.002"));
  EXPECT_THAT(reader->description().imu, HasSubstr("/mav0/imu0/data.csv; no gaps"));
  EXPECT_THAT(reader->description().remarks.findings, IsEmpty());
}

TEST(ImuSourceTest, WhatIsPassedOverLosesNoSamples) {
  const std::string folder = MakeRecording("passed");
  auto frames = PlayAll("euroc:" + folder + "?stride=3");
  EXPECT_THAT(SampleCounts(frames), ElementsAre(2001, 30, 30, 30));
  ExpectWhole(frames);
  frames = PlayAll("euroc:" + folder + "?frames=4:8&stride=2");
  EXPECT_THAT(SampleCounts(frames), ElementsAre(2001, 20, 20));
  ExpectWhole(frames);
  frames = PlayAll("euroc:" + folder + "?robot=2/2&overlap=1");
  EXPECT_THAT(SampleCounts(frames), ElementsAre(2001, 10, 10, 10, 10, 10));
  ExpectWhole(frames);
  // A picture that can't be read.
  WriteFile(absl::StrCat(folder, "/mav0/cam1/data/", kBegin_ns + 2 * kFrameInterval_ns, ".png"),
            "no picture");
  frames = PlayAll("euroc:" + folder);
  EXPECT_THAT(SampleCounts(frames), ElementsAre(2001, 10, 20, 10, 10, 10, 10, 10, 10));
  ExpectWhole(frames);
}

TEST(ImuSourceTest, PlayedBackwardsThereIsNoImu) {
  const std::string folder = MakeRecording("backwards");
  const auto frames = PlayAll("euroc:" + folder + "?reverse=1");
  EXPECT_EQ(frames.size(), 10u);
  for (const SensorImages& frame : frames) EXPECT_THAT(frame.imu, IsEmpty());
  const auto reader = ReaderOf("euroc:" + folder + "?reverse=1");
  EXPECT_FALSE(ImuOf(reader->calibration()).has_value());
  EXPECT_THAT(reader->description().imu, IsEmpty());
  ASSERT_EQ(reader->description().remarks.left_out.size(), 1u);
  EXPECT_THAT(reader->description().remarks.left_out[0], HasSubstr("played backwards"));
}

TEST(ImuSourceTest, CanBeLeftOut) {
  const std::string folder = MakeRecording("without");
  WriteFile(folder + "/mav0/imu0/data.csv", "what nobody can read\n");
  WriteFile(folder + "/mav0/imu0/sensor.yaml", "neither: this\n");
  const auto reader = ReaderOf("euroc:" + folder + "?imu=0");
  EXPECT_FALSE(ImuOf(reader->calibration()).has_value());
  EXPECT_THAT(reader->description().remarks.left_out, IsEmpty());
  for (const SensorImages& frame : PlayAll("euroc:" + folder + "?imu=0")) {
    EXPECT_THAT(frame.imu, IsEmpty());
  }
  EXPECT_FALSE(StatusOf("euroc:" + folder).ok());
  EXPECT_EQ(FormatSourceSpec(*ParseSourceSpec("euroc:DIR?imu=0")), "euroc:DIR?imu=0");
  EXPECT_THAT(MessageOf("euroc:" + folder + "?imu=1"), HasSubstr("imu=1: wants a file, or 0"));
  EXPECT_THAT(MessageOf("euroc:" + folder + "?imu"), HasSubstr("wants a file, or 0"));
}

TEST(ImuSourceTest, TheRigsImuGoesFirstWithItsClock) {
  const std::string folder = MakeRecording("rig");
  WriteFile(folder + "/rig.yaml", absl::StrCat(kPlainRig, kRigsImu, "  time_offset_s: 0.004\n"));
  // Nobody looks at it where a rig is given.
  WriteFile(folder + "/mav0/imu0/sensor.yaml", "neither: this\n");
  const std::string spec = absl::StrCat("euroc:", folder, "?rig=", folder, "/rig.yaml");
  const auto reader = ReaderOf(spec);
  const auto imu = ImuOf(reader->calibration());
  ASSERT_TRUE(imu.has_value());
  EXPECT_EQ(imu->noise.gyro, 0.001);
  EXPECT_EQ(imu->imu_from_camera.translation.x(), 0.05);
  EXPECT_NEAR(imu->rate_hz, 200, 1e-6);  // Of the list: the rig does not say.
  EXPECT_THAT(reader->description().imu,
              HasSubstr("nobody states its accel_noise, gyro_walk, accel_walk"));
  const auto frames = PlayAll(spec);
  ASSERT_EQ(frames.size(), 10u);
  // 2 ms after a frame, and moved by 4 ms: 6 ms and 1 ms after it.
  EXPECT_EQ(frames[3].imu.back().timestamp_ns, frames[3].timestamp_ns + 1'000'000);
  ExpectWhole(frames);
}

TEST(ImuSourceTest, WithoutAStatementOrSamplesItSaysSo) {
  const std::string folder = MakeRecording("unstated");
  WriteFile(folder + "/rig.yaml", kPlainRig);
  auto reader = ReaderOf(absl::StrCat("euroc:", folder, "?rig=", folder, "/rig.yaml"));
  EXPECT_FALSE(ImuOf(reader->calibration()).has_value());
  ASSERT_EQ(reader->description().remarks.left_out.size(), 1u);
  EXPECT_THAT(reader->description().remarks.left_out[0],
              HasSubstr("imu0/data.csv: what the IMU measured: nothing says where it sits"));
  // TUM-VI's recordings have a list without a sensor.yaml.
  fs::remove(folder + "/mav0/imu0/sensor.yaml");
  reader = ReaderOf("euroc:" + folder);
  EXPECT_FALSE(ImuOf(reader->calibration()).has_value());
  EXPECT_EQ(reader->description().remarks.left_out.size(), 1u);
  // A rig's IMU without samples.
  fs::remove(folder + "/mav0/imu0/data.csv");
  WriteFile(folder + "/rig.yaml", absl::StrCat(kPlainRig, kRigsImu));
  reader = ReaderOf(absl::StrCat("euroc:", folder, "?rig=", folder, "/rig.yaml"));
  EXPECT_FALSE(ImuOf(reader->calibration()).has_value());
  ASSERT_EQ(reader->description().remarks.left_out.size(), 1u);
  EXPECT_THAT(reader->description().remarks.left_out[0],
              HasSubstr("rig.yaml: its IMU, of which the recording has no samples (?imu=FILE"));
  // Nothing of an IMU at all.
  EXPECT_THAT(ReaderOf("euroc:" + folder)->description().remarks.left_out, IsEmpty());
}

TEST(ImuSourceTest, RefusesByFileWhatCantBe) {
  const std::string folder = MakeRecording("bad");
  const std::string list = folder + "/mav0/imu0/data.csv";
  WriteFile(list, ImuListText(5'000'000'000, 2600));
  EXPECT_THAT(MessageOf("euroc:" + folder), HasSubstr("they have no time in common"));
  EXPECT_THAT(MessageOf("euroc:" + folder), HasSubstr(list));
  EXPECT_TRUE(StatusOf("euroc:" + folder + "?imu=0").ok());
  WriteFile(list, ImuListText(kBegin_ns - 1'000'000'000, 2600));
  const std::string sensor = folder + "/mav0/imu0/sensor.yaml";
  const struct {
    const char *from, *to, *says;
  } cases[] = {{"sensor_type: imu", "sensor_type: camera", "sensor_type is 'camera'"},
               {"data: [0.0, -1.0", "data: [0.0, -0.5", "T_BS is no motion"},
               {"T_BS", "T_SB", "T_BS is missing"},
               {"1.6968e-04", "0", "imu.gyro_noise is 0, must be above 0"},
               {"2.0000e-3", "much", "accelerometer_noise_density is no finite number"},
               {"rate_hz: 200", "rate_hz: -200", "imu.rate_hz is -200"}};
  for (const auto& [from, to, says] : cases) {
    WriteFile(sensor, absl::StrReplaceAll(kImuYaml, {{from, to}}));
    EXPECT_THAT(MessageOf("euroc:" + folder), HasSubstr(says));
    EXPECT_THAT(MessageOf("euroc:" + folder), HasSubstr("imu0/sensor.yaml"));
  }
}

// Writes a recording in KITTI's layout, whose times begin at 0.
std::string MakeKittiRecording() {
  const std::string folder = ::testing::TempDir() + "/imu_source_kitti";
  fs::remove_all(folder);
  WriteFile(folder + "/rig.yaml", absl::StrCat(kPlainRig, kRigsImu));
  WriteFile(folder + "/plain.yaml", kPlainRig);
  std::string times;
  for (int i = 0; i < 5; ++i) {
    absl::StrAppend(&times, 0.1 * i, "\n");
    WritePicture(absl::StrFormat("%s/image_0/%06d.png", folder, i), 10 + i);
    WritePicture(absl::StrFormat("%s/image_1/%06d.png", folder, i), 10 + i);
  }
  WriteFile(folder + "/times.txt", times);
  WriteFile(folder + "/calib.txt",
            "P0: 50 0 20 0 0 50 15 0 0 0 1 0\nP1: 50 0 20 -25 0 50 15 0 0 0 1 0\n");
  WriteFile(folder + "/imu.csv", ImuListText(0, 81));
  return folder;
}

TEST(ImuSourceTest, OtherLayoutsTakeAListThatIsNamed) {
  const std::string folder = MakeKittiRecording();
  const std::string imu = absl::StrCat("&imu=", folder, "/imu.csv");
  const auto frames = PlayAll(absl::StrCat("kitti:", folder, "?rig=", folder, "/rig.yaml", imu));
  EXPECT_THAT(SampleCounts(frames), ElementsAre(1, 20, 20, 20, 20));
  ExpectWhole(frames);
  // Nothing says where it sits.
  EXPECT_THAT(MessageOf(absl::StrCat("kitti:", folder, "?rig=", folder, "/plain.yaml", imu)),
              HasSubstr("plain.yaml has no block imu: (docs/rig.md)"));
  EXPECT_THAT(MessageOf(absl::StrCat("kitti:", folder, "?imu=", folder, "/imu.csv")),
              HasSubstr("give a rig file with a block imu: (?rig=FILE, docs/rig.md)"));
  EXPECT_THAT(
      MessageOf(absl::StrCat("kitti:", folder, "?rig=", folder, "/rig.yaml&imu=/nowhere/imu.csv")),
      HasSubstr("/nowhere/imu.csv"));
}

// A list of times that falls holds two drives; the second one's first frame is not what follows
// the first one's last.
TEST(ImuSourceTest, AnotherDriveBeginsAnew) {
  const std::string folder = MakeKittiRecording();
  WriteFile(folder + "/times.txt", "20.0\n20.1\n0.0\n0.1\n0.2\n");
  WriteFile(folder + "/imu.csv", ImuListText(0, 4100));
  const auto frames = PlayAll(
      absl::StrCat("kitti:", folder, "?rig=", folder, "/rig.yaml&imu=", folder, "/imu.csv"));
  EXPECT_THAT(SampleCounts(frames), ElementsAre(2000, 20, 1, 20, 20));
}

TEST(ImuSourceTest, RealRecordingsComeWhole) {
  const char* data = std::getenv("CORBSLAM_DATA_DIR");
  if (data == nullptr && std::getenv("CI") == nullptr) GTEST_SKIP() << "no CORBSLAM_DATA_DIR";
  ASSERT_NE(data, nullptr) << "CI runs need CORBSLAM_DATA_DIR";
  for (const char* name : {"euroc_v1_01_first40", "euroc_mh_01_first200"}) {
    const std::string folder = absl::StrCat(data, "/", name);
    if (!fs::exists(folder)) continue;
    const auto reader = ReaderOf("euroc:" + folder);
    const auto imu = ImuOf(reader->calibration());
    ASSERT_TRUE(imu.has_value()) << name;
    EXPECT_THAT(reader->description().remarks.findings, IsEmpty())
        << reader->description().remarks.findings[0].text;
    EXPECT_EQ(imu->rate_hz, 200);
    // EuRoC's camera is 7 cm from its IMU.
    EXPECT_NEAR(imu->imu_from_camera.translation.norm(), 0.07, 0.01);
    SourceRemarks remarks;
    const auto all = ReadImuList(folder + "/mav0/imu0/data.csv", remarks);
    ASSERT_TRUE(all.ok()) << all.status();
    for (const char* options : {"", "?stride=3", "?frames=10:30"}) {
      const auto frames = PlayAll(absl::StrCat("euroc:", folder, options));
      ASSERT_GT(frames.size(), 10u);
      ImuSamples given;
      for (const SensorImages& frame : frames) {
        given.insert(given.end(), frame.imu.begin(), frame.imu.end());
        ASSERT_FALSE(given.empty());
        EXPECT_GE(given.back().timestamp_ns, frame.timestamp_ns);
        EXPECT_LT(given.back().timestamp_ns, frame.timestamp_ns + 6'000'000);
      }
      const ImuSamples expected = ImuBetween(*all, frames.front().timestamp_ns - 10'000'000'000,
                                             frames.back().timestamp_ns);
      ASSERT_EQ(given.size(), expected.size()) << name << options;
      for (size_t i = 0; i < given.size(); ++i) {
        EXPECT_EQ(given[i].timestamp_ns, expected[i].timestamp_ns);
        EXPECT_EQ(given[i].specific_force_mps2, expected[i].specific_force_mps2);
      }
    }
  }
}

}  // namespace
}  // namespace corbslam::client_agent

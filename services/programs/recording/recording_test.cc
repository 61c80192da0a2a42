#include "services/programs/recording/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <variant>

#include "client_agent/source/rig/rig.h"
#include "services/programs/recording/calibration_json.h"
#include "services/programs/recording/recording_files.h"
#include "services/testing/test_path.h"

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// Numbers whose decimals do not end.
constexpr double kThird = 1.0 / 3;

Rigid3d Turned() {
  Rigid3d motion;
  motion.rotation = Eigen::Quaterniond(
      Eigen::AngleAxisd(kThird, Eigen::Vector3d(1, 2, std::numbers::pi).normalized()));
  motion.translation = {-0.11, kThird * 1e-3, std::numbers::e * 1e-3};
  return motion;
}

bool AreSame(const Rigid3d& a, const Rigid3d& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

StereoCalibration RawPair() {
  RawStereo raw;
  raw.left = {458.654 + kThird, 457.296, 367.215, 248.375,
              RadialTangential{-0.28, 0.07, 1.9e-4, 1.7e-5}};
  raw.right = {457.587, 456.134, 379.999, 255.238, Equidistant{kThird, 0.1, -0.2, 1e-17}};
  raw.right_from_left = Turned();
  raw.width_px = 752;
  raw.height_px = 480;
  raw.widest_field_deg = 100 + kThird;
  StereoCalibration stereo;
  stereo.raw = raw;
  stereo.camera.close_depth_m = 4.4;
  stereo.body_from_raw_left = Turned().Inverse();
  return stereo;
}

TEST(CalibrationJsonTest, ARawPairComesBackToTheBit) {
  const StereoCalibration pair = RawPair();
  const auto json = nlohmann::ordered_json::parse(ToJson(SensorCalibration(pair)).dump());
  const auto back = CalibrationFromJson(json);
  ASSERT_TRUE(back.ok()) << back.status();
  const auto& stereo = std::get<StereoCalibration>(*back);
  ASSERT_TRUE(stereo.raw.has_value() && stereo.body_from_raw_left.has_value());
  EXPECT_TRUE(stereo.raw->left == pair.raw->left);
  EXPECT_TRUE(stereo.raw->right == pair.raw->right);
  EXPECT_TRUE(AreSame(stereo.raw->right_from_left, pair.raw->right_from_left));
  EXPECT_TRUE(AreSame(*stereo.body_from_raw_left, *pair.body_from_raw_left));
  EXPECT_EQ(stereo.raw->widest_field_deg, pair.raw->widest_field_deg);
  EXPECT_TRUE(stereo.camera == pair.camera);
}

TEST(CalibrationJsonTest, ARectifiedPairAndAnRgbdCameraComeBackToTheBit) {
  StereoCalibration pair;
  pair.camera = {718.856, 718.856, 607.1928, 185.2157, 1241, 376, 0.5371657 * kThird, 20 * kThird};
  pair.right_cx_offset_px = -kThird;
  const auto stereo = CalibrationFromJson(ToJson(SensorCalibration(pair)));
  ASSERT_TRUE(stereo.ok()) << stereo.status();
  EXPECT_TRUE(std::get<StereoCalibration>(*stereo).camera == pair.camera);
  EXPECT_EQ(std::get<StereoCalibration>(*stereo).right_cx_offset_px, -kThird);
  RgbdCalibration rgbd;
  rgbd.camera = pair.camera;
  rgbd.lens = DoubleSphere{-kThird, kThird};
  rgbd.depth_units_per_m = 1e3 * kThird;
  rgbd.body_from_raw = Turned();
  const auto depth = CalibrationFromJson(ToJson(SensorCalibration(rgbd)));
  ASSERT_TRUE(depth.ok()) << depth.status();
  const auto& back = std::get<RgbdCalibration>(*depth);
  EXPECT_TRUE(back.camera == rgbd.camera && back.lens == rgbd.lens);
  EXPECT_EQ(back.depth_units_per_m, rgbd.depth_units_per_m);
  EXPECT_TRUE(AreSame(*back.body_from_raw, Turned()));
}

TEST(CalibrationJsonTest, TheRigOfACalibrationMakesThatCalibration) {
  const StereoCalibration pair = RawPair();
  const auto made = CalibrationOf(RigOf(pair));
  ASSERT_TRUE(made.ok()) << made.status();
  const auto& stereo = std::get<StereoCalibration>(*made);
  EXPECT_TRUE(stereo.raw->left == pair.raw->left);
  EXPECT_EQ(stereo.camera.close_depth_m, pair.camera.close_depth_m);
}

TEST(CalibrationJsonTest, SaysWhatIsMissing) {
  const auto json = nlohmann::ordered_json::parse(R"({"stereo": {"camera": {"fx_px": 1}}})");
  const auto calibration = CalibrationFromJson(json);
  EXPECT_EQ(calibration.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(calibration.status().message(), HasSubstr("fy_px"));
  EXPECT_EQ(RigidFromJson(nlohmann::ordered_json::array({1, 0, 0})).status().code(),
            absl::StatusCode::kDataLoss);
}

TEST(RecordedLinesTest, AResultComesBackToTheBit) {
  ResultLine line;
  line.frame = 17;
  line.dropped = 3;
  line.result.timestamp_ns = 1403636579763555584;
  line.result.state = TrackingState::kTracking;
  line.result.local_map = {0xfedcba9876543210u};
  line.result.camera_from_local = Turned();
  line.result.points_matched = 312;
  line.result.made_keyframe = true;
  line.result.follows_keyframe = true;
  const auto back = ParseLine(FormatLine(line));
  ASSERT_TRUE(back.ok()) << back.status();
  const auto& result = std::get<ResultLine>(*back);
  EXPECT_EQ(result.frame, 17u);
  EXPECT_EQ(result.dropped, 3u);
  EXPECT_TRUE(AreEqual(result.result, line.result));
  line.result.camera_from_local.translation.x() = std::nextafter(-0.11, 0);
  EXPECT_FALSE(AreEqual(result.result, line.result));
}

class BrokenRecordingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = TestPath("recording");
    std::filesystem::remove_all(folder_);
    RecordingHead head;
    head.calibration = RawPair();
    ASSERT_TRUE(RecordingFiles::Create(folder_, head, 20).ok());
  }
  void Append(const std::string& text) { std::ofstream(LinesPath(folder_), std::ios::app) << text; }
  std::string folder_;
};

TEST_F(BrokenRecordingTest, ALineThatIsCutShortIsLeftOut) {
  Append(FormatLine(FrameLine{0, 5, false, "5.png"}) + "\n{\"result\":0,\"ti");
  const auto recording = ReadRecording(folder_);
  ASSERT_TRUE(recording.ok()) << recording.status();
  ASSERT_EQ(recording->frames.size(), 1u);
  EXPECT_FALSE(recording->frames[0].result.has_value());
  EXPECT_THAT(recording->notes, Contains(HasSubstr("frames.jsonl:2: cut short")));
  EXPECT_THAT(recording->notes, Contains(HasSubstr("ended without a word")));
}

TEST_F(BrokenRecordingTest, LinesThatCannotBeAreRefusedWithTheirNumber) {
  Append(FormatLine(FrameLine{0, 5, false, "5.png"}) + "\n" +
         FormatLine(FrameLine{2, 7, false, "7.png"}) + "\n");
  const auto recording = ReadRecording(folder_);
  EXPECT_EQ(recording.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(recording.status().message(), HasSubstr("frames.jsonl:2: frames are missing"));
}

TEST_F(BrokenRecordingTest, AnotherFolderIsNoRecording) {
  const auto recording = ReadRecording(folder_ + "/mav0");
  EXPECT_EQ(recording.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(recording.status().message(), HasSubstr("--record"));
}

TEST_F(BrokenRecordingTest, AFolderThatHoldsSomethingIsRefused) {
  EXPECT_EQ(RecordingFiles::Create(folder_, {}, std::nullopt).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace corbslam::services

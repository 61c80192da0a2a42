#include "client_agent/source/rig_opening.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/frame_reader.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr char kCameras[] =
    "cameras:\n"
    "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [81, 60]}\n";

// Writes pictures of 160 x 120 pixels in KITTI's layout, without calibration.
std::string MakeFolder() {
  const fs::path folder = fs::path(::testing::TempDir()) / "rig_opening";
  fs::remove_all(folder);
  fs::create_directories(folder / "image_0");
  fs::create_directories(folder / "image_1");
  std::ofstream times(folder / "times.txt");
  for (int i = 0; i < 4; ++i) {
    const std::string name = absl::StrFormat("%06d.png", i);
    const cv::Mat picture(120, 160, CV_8UC1, cv::Scalar(50 + i));
    cv::imwrite((folder / "image_0" / name).string(), picture);
    cv::imwrite((folder / "image_1" / name).string(), picture);
    times << 0.1 * i << "\n";
  }
  return folder.string();
}

std::string WriteRig(const std::string& text) {
  const std::string path = ::testing::TempDir() + "/opening_rig.yaml";
  std::ofstream(path) << "rig: 1\n" << text;
  return path;
}

std::string PairOf(const std::string& cameras) {
  return WriteRig(
      absl::StrCat("kind: stereo\nrectified: true\nbaseline_m: 0.1\n", cameras,
                   "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [81, 60]}\n"));
}

absl::StatusOr<std::unique_ptr<FrameReader>> Open(const std::string& options) {
  auto spec = ParseSourceSpec(absl::StrCat("kitti:", MakeFolder(), "?", options));
  if (!spec.ok()) return spec.status();
  return OpenReader(*spec);
}

TEST(RigOpeningTest, TheRigStandsInForTheRecordingsCalibration) {
  const auto reader = Open("rig=" + PairOf(kCameras));
  ASSERT_TRUE(reader.ok()) << reader.status();
  const auto& stereo = std::get<StereoCalibration>((*reader)->calibration());
  EXPECT_EQ(stereo.camera.cx_px, 81);
  EXPECT_EQ(stereo.camera.baseline_m, 0.1);
  EXPECT_THAT((*reader)->description().intrinsics_from, HasSubstr("opening_rig.yaml"));
}

// A robot's recording has the IMU's samples by the camera's clock already.
TEST(RigOpeningTest, MovesNoImuTwice) {
  const std::string folder = MakeFolder();
  const std::string imu = "imu: {imu_from_camera: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]";
  const std::string own = PairOf(kCameras);
  fs::copy_file(own, folder + "/rig.yaml");
  std::ofstream(folder + "/rig.yaml", std::ios::app) << imu << "}\n";
  std::ofstream(folder + "/recording.json") << "{}";
  std::ofstream(own, std::ios::app) << imu << ", time_offset_s: 0.01}\n";
  const auto open = [&](const std::string& options) {
    return OpenReader(*ParseSourceSpec(absl::StrCat("kitti:", folder, "?rig=", own, options)));
  };
  EXPECT_THAT(std::string(open("").status().message()), HasSubstr("has another time_offset_s"));
  EXPECT_TRUE(open("&imu=0").ok());
}

TEST(RigOpeningTest, RefusesARigOfOtherPictures) {
  const std::string other_size =
      "cameras:\n  - {size_px: [320, 120], focal_px: [100, 100], principal_px: [161, 60]}\n";
  EXPECT_THAT(std::string(Open("rig=" + PairOf(other_size)).status().message()),
              HasSubstr("left pictures have 320x120"));
  const std::string both = WriteRig(
      "kind: stereo\nrectified: true\nbaseline_m: 0.1\ncameras:\n"
      "  - {size_px: [320, 240], focal_px: [200, 200], principal_px: [161, 120]}\n"
      "  - {size_px: [320, 240], focal_px: [200, 200], principal_px: [161, 120]}\n");
  const std::string message(Open("rig=" + both).status().message());
  EXPECT_THAT(message, HasSubstr("opening_rig.yaml: is of pictures of 320x240 pixels"));
  EXPECT_THAT(message, HasSubstr("000000.png has 160x120"));
}

TEST(RigOpeningTest, NotesATimeOffsetThatMeansNothingHere) {
  const auto reader =
      Open("rig=" + WriteRig(absl::StrCat(
                        "kind: stereo\nrectified: true\nbaseline_m: 0.1\n", kCameras,
                        "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [81, 60], "
                        "time_offset_s: 0.01}\n")));
  ASSERT_TRUE(reader.ok()) << reader.status();
  const SourceFindings& findings = (*reader)->description().remarks.findings;
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, "time-offset-unused");
}

// Frames of a robot's recording were aligned before they were written.
TEST(RigOpeningTest, ARecordingIsNotAlignedTwice) {
  const fs::path folder = MakeFolder();
  std::ofstream(folder / "recording.json") << "{}";
  const auto open = [&](const std::string& rig) {
    const auto spec = ParseSourceSpec(absl::StrCat("kitti:", folder.string(), "?rig=", rig));
    return OpenReader(spec.value());
  };
  const std::string late = WriteRig(
      absl::StrCat("kind: stereo\nrectified: true\nbaseline_m: 0.1\n", kCameras,
                   "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [81, 60], "
                   "time_offset_s: 0.01}\n"));
  const std::string message(open(late).status().message());
  EXPECT_THAT(message, HasSubstr("another time_offset_s or depth.camera"));
  EXPECT_THAT(message, HasSubstr("give --rig " + (folder / "rig.yaml").string()));
  fs::copy_file(late, folder / "rig.yaml");
  EXPECT_TRUE(open((folder / "rig.yaml").string()).ok());
  fs::remove(folder / "rig.yaml");
  EXPECT_TRUE(open(PairOf(kCameras)).ok());
}

TEST(RigOpeningTest, SaysHowMuchAMaskLeavesOut) {
  const std::string mask_file = ::testing::TempDir() + "/opening_mask.png";
  cv::Mat mask(120, 160, CV_8UC1, cv::Scalar(255));
  const auto open = [&](int black_rows) {
    mask.rowRange(0, black_rows).setTo(0);
    cv::imwrite(mask_file, mask);
    const std::string rig = PairOf(kCameras);
    std::ofstream(rig, std::ios::app) << "mask: opening_mask.png\n";
    return Open("rig=" + rig);
  };
  const auto quarter = open(30);
  ASSERT_TRUE(quarter.ok()) << quarter.status();
  EXPECT_THAT(DescribeInLines((*quarter)->description()),
              ::testing::Contains(
                  std::pair<std::string, std::string>("mask", "leaves out 25.0 % of the picture")));
  EXPECT_TRUE((*quarter)->description().remarks.findings.empty());
  const auto most = open(96);
  ASSERT_TRUE(most.ok()) << most.status();
  ASSERT_EQ((*most)->description().remarks.findings.size(), 1u);
  EXPECT_EQ((*most)->description().remarks.findings[0].code, "mask-wide");
  EXPECT_THAT(std::string(open(120).status().message()), HasSubstr("is it inverted?"));
  const std::string rig = PairOf(kCameras);
  std::ofstream(rig, std::ios::app) << "mask: nowhere.png\n";
  const std::string message(Open("rig=" + rig).status().message());
  EXPECT_THAT(message, HasSubstr("opening_rig.yaml: mask: "));
  EXPECT_THAT(message, HasSubstr("nowhere.png"));
}

// A file whose name holds what ends an option.
TEST(RigOpeningTest, TakesAnyNameOfAFile) {
  const fs::path named = fs::path(::testing::TempDir()) / "a&b,c%26d.yaml";
  fs::copy_file(PairOf(kCameras), named, fs::copy_options::overwrite_existing);
  const std::string written =
      "rig=" + absl::StrReplaceAll(named.string(), {{"%26", "%2526"}, {"&", "%26"}, {",", "%2C"}});
  const auto reader = Open(written);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ((*reader)->description().intrinsics_from, named.string());
  auto spec = ParseSourceSpec("kitti:/somewhere");
  ASSERT_TRUE(UseRig(named.string(), *spec).ok());
  const auto again = ParseSourceSpec(FormatSourceSpec(*spec));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->opening.rig_file, named.string()) << FormatSourceSpec(*spec);
}

TEST(RigOpeningTest, RefusesARigOfAnotherKind) {
  const std::string rgbd =
      WriteRig(absl::StrCat("kind: rgbd\ndepth: {units_per_m: 1000}\n", kCameras));
  EXPECT_THAT(std::string(Open("rig=" + rgbd).status().message()),
              HasSubstr("is of an RGB-D camera, this recording is of a stereo pair"));
}

TEST(RigOpeningTest, AnImprobableRigMustBeTrusted) {
  const std::string askew =
      "cameras:\n  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [120, 60]}\n";
  const std::string pair = WriteRig(
      absl::StrCat("kind: stereo\nrectified: true\nbaseline_m: 0.1\n", askew,
                   "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [120, 60]}\n"));
  EXPECT_THAT(std::string(Open("rig=" + pair).status().message()), HasSubstr("can't be"));
  const auto trusted = Open(absl::StrCat("rig=", pair, "&trust_calibration=1"));
  ASSERT_TRUE(trusted.ok()) << trusted.status();
  EXPECT_FALSE((*trusted)->description().remarks.findings.empty());
}

TEST(RigOpeningTest, TheOptionIsWrittenBack) {
  const auto spec = ParseSourceSpec("kitti:" + MakeFolder() + "?rig=/a/rig.yaml&scale=0.5");
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_THAT(FormatSourceSpec(*spec), HasSubstr("rig=/a/rig.yaml&scale=0.5"));
  EXPECT_FALSE(ParseSourceSpec("kitti:" + MakeFolder() + "?scale=2").ok());
  EXPECT_FALSE(ParseSourceSpec("kitti:" + MakeFolder() + "?rig=").ok());
}

TEST(RigOpeningTest, ARigOfOneCameraPlaysTheFirstAlone) {
  const std::string rig = WriteRig(absl::StrCat("kind: monocular\n", kCameras));
  const auto reader = Open("rig=" + rig);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ(KindOf((*reader)->calibration()), SensorKind::kMonocular);
  const auto images = (*reader)->Read(2);
  ASSERT_TRUE(images.ok()) << images.status();
  EXPECT_EQ(images->grey.at<uint8_t>(0, 0), 52);
  EXPECT_TRUE(images->right.empty());
}

TEST(RigOpeningTest, OfAPairsRigTheFirstCameraIsTaken) {
  const auto reader = Open(absl::StrCat("cameras=1&scale=0.8&rig=", PairOf(kCameras)));
  ASSERT_TRUE(reader.ok()) << reader.status();
  const auto& one = std::get<MonocularCalibration>((*reader)->calibration());
  EXPECT_EQ(one.camera.width_px, 128);
  EXPECT_DOUBLE_EQ(one.camera.fx_px, 80);
  EXPECT_DOUBLE_EQ(one.camera.baseline_m, 0);
}

}  // namespace
}  // namespace corbslam::client_agent

#include "services/tool/sequence/sequence_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/evaluation/accuracy.h"

namespace corbslam::services {

using client_agent::OpenReader;
using client_agent::ParseSourceSpec;
using client_agent::ReadPerturbed;
using client_agent::SourceLayout;
using client_agent::SourceSpec;

namespace {

[[maybe_unused]] const bool registered = RegisterSimulatedSources();

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr char kSmall[] = "sim:city?seed=3&length=120&picture_scale=0.12&frames=4:9&noise=1";

std::string Write(const std::string& source, SourceLayout layout, const std::string& name,
                  int threads = 1) {
  const std::string folder = ::testing::TempDir() + "/sequence_writer_" + name;
  fs::remove_all(folder);
  WriteSequenceOptions options;
  options.layout = layout;
  options.folder = folder;
  options.threads = threads;
  const absl::StatusOr<size_t> frames = WriteSequence(*ParseSourceSpec(source), options);
  EXPECT_TRUE(frames.ok()) << frames.status();
  EXPECT_EQ(frames.value_or(0), 6u);
  return folder;
}

std::map<std::string, std::string> ReadFolder(const std::string& folder) {
  std::map<std::string, std::string> contents;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    contents[fs::relative(entry.path(), folder).string()] =
        std::string(std::istreambuf_iterator<char>(file), {});
  }
  return contents;
}

double Difference(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty() && b.empty()) return 0;
  return a.size() == b.size() && a.type() == b.type() ? cv::norm(a, b, cv::NORM_INF) : 1e9;
}

struct Case {
  SourceLayout layout;
  const char* name;
  const char* rig;
};

class LayoutTest : public ::testing::TestWithParam<Case> {};

TEST_P(LayoutTest, IsReadBackAsItWasDrawn) {
  const Case& c = GetParam();
  const std::string folder = Write(kSmall, c.layout, c.name);
  const SourceSpec drawn_spec = *ParseSourceSpec(absl::StrCat(kSmall, "&rig=", c.rig));
  const SourceSpec read_spec = *ParseSourceSpec(absl::StrCat(c.name, ":", folder));
  const auto drawn = OpenReader(drawn_spec);
  const auto read = OpenReader(read_spec);
  ASSERT_TRUE(drawn.ok() && read.ok()) << drawn.status() << read.status();
  const auto drawn_truth = ReadGroundTruth(drawn_spec);
  const auto read_truth = ReadGroundTruth(read_spec);
  ASSERT_TRUE(read_truth.ok() && read_truth->has_value()) << read_truth.status();
  ASSERT_EQ((*read)->frame_count(), 6u);
  ASSERT_EQ((*read_truth)->trajectory.size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    const absl::StatusOr<SensorImages> one = ReadPerturbed(**drawn, i + 4, drawn_spec.perturbation);
    const absl::StatusOr<SensorImages> other = (*read)->Read(i);
    ASSERT_TRUE(one.ok() && other.ok()) << one.status() << other.status();
    EXPECT_EQ(other->timestamp_ns, one->timestamp_ns);
    EXPECT_EQ(Difference(one->grey, other->grey), 0);
    EXPECT_EQ(Difference(one->right, other->right), 0);
    EXPECT_EQ(Difference(one->depth, other->depth), 0);
    const StampedPose& was = (*drawn_truth)->trajectory[i + 4];
    const StampedPose& is = (*read_truth)->trajectory[i];
    EXPECT_EQ(is.timestamp_ns, was.timestamp_ns);
    EXPECT_LT((is.world_from_camera.translation - was.world_from_camera.translation).norm(), 1e-6);
    EXPECT_LT(
        RotationAngle(is.world_from_camera.rotation.conjugate() * was.world_from_camera.rotation),
        1e-6);
  }
}

TEST_P(LayoutTest, KeepsTheCalibration) {
  const Case& c = GetParam();
  const std::string folder = Write(kSmall, c.layout, c.name);
  const auto drawn = OpenReader(*ParseSourceSpec(absl::StrCat(kSmall, "&rig=", c.rig)));
  const auto read = OpenReader(*ParseSourceSpec(absl::StrCat(c.name, ":", folder)));
  ASSERT_TRUE(drawn.ok() && read.ok());
  // The pictures are compared as the sensor has them: EuRoC's go through a rectification that has
  // nothing to do.
  const auto a = MakeSensor((*drawn)->calibration(), {});
  const auto b = MakeSensor((*read)->calibration(), {});
  ASSERT_TRUE(a.ok() && b.ok()) << a.status() << b.status();
  const Camera& one = (*a)->camera();
  const Camera& other = (*b)->camera();
  EXPECT_EQ(one.width_px, other.width_px);
  EXPECT_EQ(one.height_px, other.height_px);
  EXPECT_NEAR(one.baseline_m, other.baseline_m, 1e-9);
  EXPECT_NEAR(one.close_depth_m, other.close_depth_m, 1e-9);
  const double off_px = c.layout == SourceLayout::kEuroc ? 2 : 1e-9;
  EXPECT_NEAR(one.fx_px, other.fx_px, off_px);
  EXPECT_NEAR(one.cx_px, other.cx_px, off_px);
  EXPECT_NEAR(one.cy_px, other.cy_px, off_px);
}

INSTANTIATE_TEST_SUITE_P(All, LayoutTest,
                         ::testing::Values(Case{SourceLayout::kKitti, "kitti", "kitti"},
                                           Case{SourceLayout::kEuroc, "euroc", "euroc"},
                                           Case{SourceLayout::kTum, "tum", "rgbd"}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(WriteSequenceTest, WhatAnImuMeasuredIsReadBack) {
  const std::string source = absl::StrCat(kSmall, "&imu=phone");
  const std::string folder = Write(source, SourceLayout::kEuroc, "imu");
  const auto drawn = OpenReader(*ParseSourceSpec(source + "&rig=euroc"));
  const auto read = OpenReader(*ParseSourceSpec("euroc:" + folder));
  ASSERT_TRUE(drawn.ok() && read.ok()) << drawn.status() << read.status();
  const auto imu_of = [](const SensorCalibration& calibration) {
    return std::visit([](const auto& sensor) { return sensor.imu; }, calibration);
  };
  const std::optional<ImuCalibration> told = imu_of((*drawn)->calibration());
  const std::optional<ImuCalibration> found = imu_of((*read)->calibration());
  ASSERT_TRUE(told.has_value() && found.has_value());
  EXPECT_NEAR(found->rate_hz, told->rate_hz, 1e-6);
  EXPECT_NEAR(found->noise.accel_walk, told->noise.accel_walk, 1e-9);
  const Rigid3d apart = found->imu_from_camera.Inverse() * told->imu_from_camera;
  EXPECT_LT(apart.translation.norm() + RotationAngle(apart.rotation), 1e-6);
  const int64_t from_ns = (*drawn)->timestamp_ns(5);
  const ImuSamples was = (*drawn)->Imu(from_ns, from_ns + 50'000'000);
  const ImuSamples is = (*read)->Imu(from_ns, from_ns + 50'000'000);
  ASSERT_EQ(is.size(), 10u);
  ASSERT_EQ(was.size(), 10u);
  EXPECT_EQ(is[7].timestamp_ns, was[7].timestamp_ns);
  EXPECT_EQ(is[7].specific_force_mps2, was[7].specific_force_mps2);
  WriteSequenceOptions options;
  options.layout = SourceLayout::kKitti;
  options.folder = folder + "_kitti";
  EXPECT_THAT(std::string(WriteSequence(*ParseSourceSpec(source), options).status().message()),
              HasSubstr("only the layout euroc"));
}

// Both layouts say which lenses took the pictures; the body of EuRoC's truth is the left camera.
TEST(WriteSequenceTest, APairAskewIsReadBackWithItsLenses) {
  const std::string rig = ::testing::TempDir() + "/sequence_writer_rig.yaml";
  std::ofstream(rig) << "rig: 1\nkind: stereo\ncameras:\n"
                        "  - {size_px: [160, 120], focal_px: [60, 60], principal_px: [80, 60],\n"
                        "     lens: equidistant, lens_numbers: [0.01, 0, 0, 0]}\n"
                        "  - {size_px: [160, 120], focal_px: [61, 61], principal_px: [79, 60],\n"
                        "     lens: equidistant, lens_numbers: [0.02, 0, 0, 0]}\n"
                        "right_from_left: [0.9998, -0.02, 0, -0.2, 0.02, 0.9998, 0, 0.001,\n"
                        "                  0, 0, 1, 0, 0, 0, 0, 1]\n";
  const std::string source = "sim:city?seed=3&length=120&frames=4:9&rig=" + rig;
  for (const auto& [name, layout] :
       {std::pair("kitti", SourceLayout::kKitti), {"euroc", SourceLayout::kEuroc}}) {
    const std::string folder = Write(source, layout, std::string("askew_") + name);
    const std::string with = name[0] == 'k' ? "?rig=" + folder + "/rig.yaml" : "";
    const SourceSpec read_spec = *ParseSourceSpec(absl::StrCat(name, ":", folder, with));
    const auto read = OpenReader(read_spec);
    const auto drawn = OpenReader(*ParseSourceSpec(source));
    ASSERT_TRUE(read.ok() && drawn.ok()) << read.status() << drawn.status();
    const auto& stereo = std::get<StereoCalibration>((*read)->calibration());
    ASSERT_TRUE(stereo.raw.has_value());
    EXPECT_EQ(std::get<Equidistant>(stereo.raw->right.lens).k1, 0.02);
    EXPECT_NEAR(stereo.raw->right_from_left.translation.x(), -0.2, 1e-9);
    EXPECT_NEAR(RotationAngle(stereo.raw->right_from_left.rotation), 0.02, 1e-4);
    const auto one = (*drawn)->Read(6);
    const auto other = (*read)->Read(2);
    ASSERT_TRUE(one.ok() && other.ok());
    EXPECT_EQ(Difference(one->right, other->right), 0);
    const auto truth = ReadGroundTruth(read_spec);
    ASSERT_TRUE(truth.ok() && truth->has_value()) << truth.status();
    EXPECT_EQ((*truth)->trajectory.size(), 6u);
  }
}

TEST(WriteSequenceTest, IsTheSameToTheByteWithAnyThreads) {
  const auto one = ReadFolder(Write(kSmall, SourceLayout::kKitti, "one"));
  const auto two = ReadFolder(Write(kSmall, SourceLayout::kKitti, "two", 2));
  EXPECT_EQ(one.size(), 15u);
  EXPECT_TRUE(one == two);
}

TEST(WriteSequenceTest, ReportsItsProgress) {
  WriteSequenceOptions options;
  options.folder = ::testing::TempDir() + "/sequence_writer_progress";
  options.threads = 2;
  std::vector<std::pair<size_t, size_t>> calls;
  options.on_progress = [&](size_t done, size_t total) { calls.emplace_back(done, total); };
  ASSERT_TRUE(WriteSequence(*ParseSourceSpec(kSmall), options).ok());
  ASSERT_EQ(calls.size(), 6u);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(calls[i], std::pair(i + 1, size_t{6}));
}

TEST(WriteSequenceTest, RefusesWhatItCannotWrite) {
  const std::tuple<const char*, SourceLayout, const char*> cases[] = {
      {"kitti:somewhere", SourceLayout::kKitti, "no simulation"},
      {"sim:city?reverse=1", SourceLayout::kKitti, "reverse"},
      {"sim:city?rig=rgbd", SourceLayout::kEuroc, "rig=euroc"},
      {"sim:city?rig=kitti", SourceLayout::kTum, "rig=rgbd"}};
  for (const auto& [source, layout, expected] : cases) {
    WriteSequenceOptions options;
    options.layout = layout;
    options.folder = ::testing::TempDir() + "/sequence_writer_refused";
    const absl::Status status = WriteSequence(*ParseSourceSpec(source), options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << source;
    EXPECT_THAT(std::string(status.message()), HasSubstr(expected));
  }
}

TEST(WriteSequenceTest, NamesTheFolderItCannotMake) {
  WriteSequenceOptions options;
  options.folder = "/proc/nothing";
  const absl::Status status = WriteSequence(*ParseSourceSpec(kSmall), options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("/proc/nothing"));
}

}  // namespace
}  // namespace corbslam::services

// RGB-D recordings that are played with a rig: depth that is registered, and times that differ.
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

constexpr char kRig[] =
    "rig: 1\nkind: rgbd\ncameras:\n"
    "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [80, 60]}\n"
    "depth:\n  units_per_m: 1000\n";
constexpr char kDepthCamera[] =
    "  camera: {size_px: [80, 60], focal_px: [50, 50], principal_px: [39.75, 29.75]}\n"
    "  colour_from_depth: [1, 0, 0, 0.02, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";

std::string Folder(const std::string& name) {
  const std::string folder = absl::StrCat(::testing::TempDir(), "/rgbd_rig_", name);
  fs::remove_all(folder);
  fs::create_directories(folder + "/rgb");
  fs::create_directories(folder + "/depth");
  return folder;
}

std::string Write(const std::string& path, const std::string& text) {
  std::ofstream(path) << text;
  return path;
}

// Depth of 80x60 pixels, 2 m everywhere; depth images are stamped 100 ms late.
std::string MakeTum(const std::string& name) {
  const std::string folder = Folder(name);
  std::string rgb, depth;
  for (int i = 0; i < 4; ++i) {
    cv::imwrite(absl::StrCat(folder, "/rgb/", i, ".png"),
                cv::Mat(120, 160, CV_8UC1, cv::Scalar(50 + i)));
    cv::imwrite(absl::StrCat(folder, "/depth/", i, ".png"),
                cv::Mat(60, 80, CV_16UC1, cv::Scalar(2000 + i)));
    absl::StrAppend(&rgb, absl::StrFormat("%.3f rgb/%d.png\n", 1 + 0.05 * i, i));
    absl::StrAppend(&depth, absl::StrFormat("%.3f depth/%d.png\n", 1.1 + 0.05 * i, i));
  }
  Write(folder + "/rgb.txt", rgb);
  Write(folder + "/depth.txt", depth);
  return folder;
}

absl::StatusOr<std::unique_ptr<FrameReader>> Open(const std::string& source, const std::string& rig,
                                                  const std::string& more = "") {
  const std::string path = Write(::testing::TempDir() + "/rgbd_rig.yaml", rig);
  const auto spec = ParseSourceSpec(absl::StrCat(source, "?rig=", path, more));
  if (!spec.ok()) return spec.status();
  return OpenReader(*spec);
}

TEST(RgbdRigTest, DepthIsRegisteredByTheRig) {
  const auto reader = Open("tum:" + MakeTum("registered"), absl::StrCat(kRig, kDepthCamera));
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_THAT((*reader)->description().depth_registration, HasSubstr("80x60, 20.0 mm beside"));
  const auto images = (*reader)->Read(0);
  ASSERT_TRUE(images.ok()) << images.status();
  EXPECT_EQ(images->depth.size(), cv::Size(160, 120));
  // Moved by 100 * 0.02 / 2 = 1 pixel to the right, of which the first column is left empty.
  EXPECT_EQ(images->depth.at<uint16_t>(50, 0), 0);
  EXPECT_GE(images->depth.at<uint16_t>(50, 1), 2000);
  EXPECT_EQ(cv::countNonZero(images->depth), 159 * 120);
}

TEST(RgbdRigTest, SevenScenesToo) {
  const std::string folder = Folder("scenes");
  cv::imwrite(folder + "/frame-000000.color.png", cv::Mat(120, 160, CV_8UC3, cv::Scalar(9, 9, 9)));
  cv::imwrite(folder + "/frame-000000.depth.png", cv::Mat(60, 80, CV_16UC1, cv::Scalar(2000)));
  const auto reader = Open("7scenes:" + folder, absl::StrCat(kRig, kDepthCamera), "&fps=30");
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ(cv::countNonZero((*reader)->Read(0)->depth), 159 * 120);
}

TEST(RgbdRigTest, WhatCantBeRegisteredIsRefused) {
  const std::string tum = "tum:" + MakeTum("refused");
  EXPECT_THAT(std::string(Open(tum, kRig, "&register=1").status().message()),
              HasSubstr("rgbd_rig.yaml: to register depth, the rig must say"));
  const auto spec = ParseSourceSpec(tum + "?register=1&camera=freiburg1");
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_THAT(std::string(OpenReader(*spec).status().message()), HasSubstr("needs a rig"));
  // It is not registered, and of another size.
  const auto reader = Open(tum, absl::StrCat(kRig, kDepthCamera), "&register=0");
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_THAT(std::string((*reader)->Read(0).status().message()),
              HasSubstr("depth/0.png: 80x60 pixels, the calibration is of 160x120"));
  const std::string larger = absl::StrReplaceAll(kDepthCamera, {{"[80, 60]", "[90, 60]"}});
  EXPECT_THAT(
      std::string((*Open(tum, kRig + larger))->Read(0).status().message()),
      HasSubstr("depth/0.png: a depth picture of 80x60 CV_16UC1, its camera's are of 90x60"));
}

TEST(RgbdRigTest, TimesOfDepthMayDiffer) {
  const std::string tum = "tum:" + MakeTum("times");
  const std::string rig = absl::StrCat(kRig, kDepthCamera);
  // By their stamps alone the third picture has the first depth image.
  auto reader = Open(tum, rig);
  ASSERT_EQ((*reader)->frame_count(), 2u);
  reader = Open(tum, rig + "  time_offset_s: -0.1\n");
  ASSERT_TRUE(reader.ok()) << reader.status();
  ASSERT_EQ((*reader)->frame_count(), 4u);
  EXPECT_EQ((*reader)->timestamp_ns(0), 1'000'000'000);
  EXPECT_EQ((*reader)->Read(2)->depth.at<uint16_t>(50, 50), 2002);
  EXPECT_THAT(std::string(Open(tum, rig + "  time_offset_s: -100\n").status().message()),
              HasSubstr("the two cameras differ by -100 s, must be at most 0.5"));
}

}  // namespace
}  // namespace corbslam::client_agent

#include "client_agent/source/rig/rig_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

Rig OneCamera() {
  Rig rig;
  rig.kind = RigKind::kRgbd;
  rig.cameras = {{{100, 100, 20, 16, {}}, 40, 32}};
  return rig;
}

// Half as large, at the same place: each of its pixels covers two by two of the other's.
Rig WithDepthCamera() {
  Rig rig = OneCamera();
  rig.depth.camera = RigCamera{{50, 50, 9.75, 7.75, {}}, 20, 16};
  return rig;
}

cv::Mat Depth(int width, int height) { return {height, width, CV_16UC1, cv::Scalar(2000)}; }

TEST(DepthPreparationTest, RegistersWhereTheRigHasACameraOfDepth) {
  const auto preparation = DepthPreparation::Make(WithDepthCamera(), std::nullopt);
  ASSERT_TRUE(preparation.ok()) << preparation.status();
  EXPECT_TRUE(preparation->registers());
  EXPECT_EQ(preparation->raw_size(), cv::Size(20, 16));
  EXPECT_THAT(preparation->description(), HasSubstr("from a camera of 20x16, 0.0 mm beside"));
  cv::Mat depth = Depth(20, 16);
  depth.at<uint16_t>(3, 4) = 0;
  const auto prepared = preparation->Prepare(depth);
  ASSERT_TRUE(prepared.ok()) << prepared.status();
  EXPECT_EQ(prepared->size(), cv::Size(40, 32));
  EXPECT_EQ(cv::countNonZero(*prepared), 40 * 32 - 4);
  EXPECT_EQ(prepared->at<uint16_t>(7, 9), 0);
  EXPECT_EQ(prepared->at<uint16_t>(8, 10), 2000);
  EXPECT_FALSE(preparation->Prepare(Depth(40, 32)).ok());
}

TEST(DepthPreparationTest, LeavesWhatIsRegisteredAlready) {
  for (const auto& [rig, registers] :
       {std::pair(OneCamera(), std::optional<bool>()), {WithDepthCamera(), false}}) {
    const auto preparation = DepthPreparation::Make(rig, registers);
    ASSERT_TRUE(preparation.ok()) << preparation.status();
    EXPECT_FALSE(preparation->registers());
    EXPECT_FALSE(preparation->raw_size().has_value());
    EXPECT_THAT(preparation->description(), IsEmpty());
    const cv::Mat depth = Depth(40, 32);
    EXPECT_EQ(preparation->Prepare(depth)->data, depth.data) << "it is shared";
  }
}

TEST(DepthPreparationTest, WhatTheRigSaysIsNoDepthIsNone) {
  Rig rig = OneCamera();
  rig.depth.no_depth = {2047, 65535};
  const auto preparation = DepthPreparation::Make(rig, std::nullopt);
  cv::Mat depth = Depth(40, 32);
  depth.at<uint16_t>(2, 2) = 2047;
  depth.at<uint16_t>(3, 3) = 65535;
  const auto prepared = preparation->Prepare(depth);
  EXPECT_EQ(prepared->at<uint16_t>(2, 2), 0);
  EXPECT_EQ(prepared->at<uint16_t>(3, 3), 0);
  EXPECT_EQ(cv::countNonZero(*prepared), 40 * 32 - 2);
  EXPECT_EQ(depth.at<uint16_t>(2, 2), 2047) << "what was given stays as it is";
}

TEST(DepthPreparationTest, RefusesWithoutTheCameraOfDepth) {
  EXPECT_THAT(std::string(DepthPreparation::Make(OneCamera(), true).status().message()),
              HasSubstr("depth.colour_from_depth"));
  Rig far = WithDepthCamera();
  far.depth.colour_from_depth.translation.x() = -25;
  EXPECT_THAT(std::string(DepthPreparation::Make(far, std::nullopt).status().message()),
              HasSubstr("25 m apart"));
  Rig pair = OneCamera();
  pair.kind = RigKind::kStereo;
  EXPECT_FALSE(DepthPreparation::Make(pair, std::nullopt).ok());
}

}  // namespace
}  // namespace corbslam::client_agent

#include "services/programs/robot/told_poses.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using client_agent::TrackingResult;
using client_agent::TrackingState;

constexpr LocalMapId kMap = {7};

Similarity3d Shifted(double x, double scale = 1) {
  return {scale, Eigen::Quaterniond::Identity(), {x, 0, 0}};
}

// A frame of a camera that drove `x` metres along its map's first axis.
TrackingResult Placed(TrackingResult result, const Similarity3d& global_from_local) {
  result.global_from_local = global_from_local;
  return result;
}

TrackingResult At(double x, uint64_t epoch = 1, LocalMapId map = kMap) {
  TrackingResult result;
  result.timestamp_ns = static_cast<int64_t>(x * 1e9) + 1;
  result.state = TrackingState::kTracking;
  result.local_map = map;
  result.epoch = epoch;
  const Rigid3d local_from_camera = {Eigen::Quaterniond::Identity(), {x, 0, 0}};
  result.camera_from_local = local_from_camera.Inverse();
  result.odom_from_camera = local_from_camera;
  return result;
}

TEST(ToldPosesTest, WhatWasToldStays) {
  ToldPoses told({});
  told.Add(At(0));
  told.Add(Placed(At(1), Shifted(10)));
  told.Add(Placed(At(2), Shifted(10, 2)));
  ASSERT_EQ(told.paths().local.size(), 3u);
  ASSERT_EQ(told.paths().global.size(), 2u);
  EXPECT_EQ(told.paths().global[0].world_from_camera.translation.x(), 11);
  EXPECT_EQ(told.paths().global[1].world_from_camera.translation.x(), 14);
}

TEST(ToldPosesTest, AMotionIsNoJumpAndACorrectionIs) {
  ToldPoses told({});
  told.Add(Placed(At(0), Shifted(10)));
  told.Add(Placed(At(1), Shifted(10)));
  EXPECT_EQ(told.jumps().count, 0u);
  told.Add(Placed(At(2), Shifted(9.5)));
  EXPECT_EQ(told.jumps().count, 1u);
  EXPECT_NEAR(told.jumps().largest_m, 0.5, 1e-12);
  // The local map is put right by a metre under the camera.
  TrackingResult corrected = At(4, 2);
  corrected.odom_from_camera->translation.x() = 3;
  told.Add(Placed(corrected, Shifted(9.5)));
  EXPECT_EQ(told.jumps().count, 2u);
  EXPECT_NEAR(told.jumps().largest_m, 1, 1e-12);
  EXPECT_NEAR(told.jumps().sum_m, 1.5, 1e-12);
}

TEST(ToldPosesTest, JumpsAreCountedWithoutPaths) {
  ToldPoses told({}, /*keeps_paths=*/false);
  told.Add(Placed(At(0), Shifted(10)));
  told.Add(Placed(At(1), Shifted(9.5)));
  EXPECT_EQ(told.jumps().count, 1u);
  EXPECT_TRUE(told.paths().local.empty() && told.paths().global.empty());
}

TEST(ToldPosesTest, NobodyKnowsWhatHappenedWhileItWasLost) {
  ToldPoses told({});
  told.Add(Placed(At(0), Shifted(10)));
  TrackingResult lost = At(1);
  lost.state = TrackingState::kLost;
  told.Add(Placed(lost, Shifted(10)));
  told.Add(Placed(At(5, 2), Shifted(10)));
  EXPECT_EQ(told.jumps().count, 0u);
  EXPECT_EQ(told.paths().global.size(), 2u);
}

TEST(ToldPosesTest, PosesOfSeveralLocalMapsAreNoPath) {
  ToldPoses told({});
  told.Add(At(0));
  told.Add(Placed(At(1, 2, {8}), Shifted(1)));
  EXPECT_TRUE(told.paths().local.empty());
  EXPECT_EQ(told.paths().global.size(), 1u);
}

TEST(ToldPosesTest, PosesAreOfTheCameraThatRecorded) {
  RecordedCamera turned;
  turned.camera_from_recorded.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
  ToldPoses told(turned);
  told.Add(Placed(At(1), Shifted(0)));
  EXPECT_NEAR(RotationAngle(told.paths().local[0].world_from_camera.rotation), 0.5, 1e-12);
  EXPECT_NEAR(RotationAngle(told.paths().global[0].world_from_camera.rotation), 0.5, 1e-12);
}

TEST(ToldPosesTest, FilesGiveBackWhatWasTold) {
  ToldPoses told({});
  told.Add(Placed(At(1), Shifted(10)));
  told.Add(Placed(At(2), Shifted(10)));
  const std::string stem = ::testing::TempDir() + "/alpha.told";
  ASSERT_TRUE(WriteToldPaths(told.paths(), stem).ok());
  const auto read = ReadToldPaths(stem);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->global.size(), 2u);
  EXPECT_EQ(read->global[1].timestamp_ns, 2'000'000'001);
  EXPECT_NEAR(read->global[1].world_from_camera.translation.x(), 12, 1e-9);
  EXPECT_EQ(read->local.size(), 2u);
  EXPECT_FALSE(ReadToldPaths(stem + "nowhere").ok());
}

}  // namespace
}  // namespace corbslam::services

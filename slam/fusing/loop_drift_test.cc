// These maps have no points, so the scene's depth is 1.
#include "slam/fusing/loop_drift.h"

#include <gtest/gtest.h>

#include "slam/fusing/testing/long_drive.h"

namespace corbslam {
namespace {

using testing::AddDrive;
using testing::SayOverlap;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};
constexpr uint32_t kKeyframes = 200;

// Two local maps of one island; B goes on where A ends.
class LoopDriftTest : public ::testing::Test {
 protected:
  LoopDriftTest() {
    AddDrive(kA, 0, kKeyframes, /*depth_m=*/0, request_.target);
    AddDrive(kB, kKeyframes, kKeyframes, /*depth_m=*/0, request_.target);
    request_.overlaps = {Say({kB, 0}, {kA, kKeyframes - 1}, Eigen::Vector3d::Zero())};
  }

  Overlap Say(KeyframeId query, KeyframeId candidate, const Eigen::Vector3d& wrong_by,
              double turned_by_rad = 0) const {
    return SayOverlap(request_.target, query, candidate, wrong_by, turned_by_rad);
  }

  bool IsAccepted(const std::vector<Overlap>& later) {
    FuseMapsRequest request = request_;
    for (const Overlap& overlap : later) {
      request.new_overlaps.push_back(request.overlaps.size());
      request.overlaps.push_back(overlap);
    }
    const auto result = FuseMaps(request, {}, nullptr);
    EXPECT_TRUE(result.ok()) << result.status();
    return result.ok() && result->accepted;
  }

  FuseMapsRequest request_;
};

TEST_F(LoopDriftTest, TheWayLeadsThroughOtherLocalMapsAndTheirOverlaps) {
  const KeyframeId last{kB, kKeyframes - 1};
  const KeyframeId first{kA, 0};
  EXPECT_TRUE(IsAccepted({Say(last, first, {0, 0, 20})}));
  EXPECT_FALSE(IsAccepted({Say(last, first, {0, 0, 60})})) << "400 m drift 40 at most";
  const KeyframeId near{kB, 5};
  const KeyframeId nearest{kA, kKeyframes - 5};
  EXPECT_TRUE(IsAccepted({Say(near, nearest, {0, 0, 0.3})}));
  EXPECT_FALSE(IsAccepted({Say(near, nearest, {0, 0, 3})})) << "10 m drift 1 at most";
}

TEST_F(LoopDriftTest, WhatIsSeenMayNotTurnAwayEither) {
  const KeyframeId near{kB, 1};
  const KeyframeId nearest{kA, kKeyframes - 2};
  EXPECT_TRUE(IsAccepted({Say(near, nearest, Eigen::Vector3d::Zero(), 0.2)}));
  EXPECT_FALSE(IsAccepted({Say(near, nearest, Eigen::Vector3d::Zero(), 2.5)}));
}

TEST_F(LoopDriftTest, InOneLocalMapTheWayIsItsOwn) {
  EXPECT_TRUE(IsAccepted({Say({kA, 150}, {kA, 0}, {0, 0, 10})}));
  EXPECT_FALSE(IsAccepted({Say({kA, 150}, {kA, 0}, {0, 0, 25})}));
}

TEST_F(LoopDriftTest, AMapThatBentItselfIsNotJudgedByWhereItWas) {
  // B has come back along A, and was found twice; then it bent itself, from keyframe 50 on.
  request_.target = Map();
  AddDrive(kA, 0, kKeyframes, /*depth_m=*/0, request_.target);
  AddDrive(kB, 0, kKeyframes, /*depth_m=*/0, request_.target);
  request_.overlaps = {Say({kB, 5}, {kA, 5}, Eigen::Vector3d::Zero()),
                       Say({kB, 150}, {kA, 150}, Eigen::Vector3d::Zero())};
  const Overlap next = Say({kB, 152}, {kA, 152}, Eigen::Vector3d::Zero());
  for (uint32_t k = 50; k < kKeyframes; ++k) {
    Rigid3d pose = request_.target.FindKeyframe({kB, k})->camera_from_map;
    pose.translation.z() -= 5;
    request_.target.SetPose({kB, k}, pose);
  }
  EXPECT_TRUE(IsAccepted({next}));
}

// What an earlier overlap joined may have been wrong: several may find that out.
TEST_F(LoopDriftTest, SeveralMayContradictHowOthersWereJoined) {
  const KeyframeId last{kB, kKeyframes - 1};
  FusingProblem problem;
  const Map none;
  problem.target = &request_.target;
  problem.source = &none;
  const OrientedOverlap loop = Orient(Say(last, {kA, 0}, {0, 0, 60}), false);
  problem.overlaps = {Orient(request_.overlaps[0], false), loop};
  problem.new_overlaps = {1};
  EXPECT_GT(DriftOfLoop(problem, loop, {}), 1);
  problem.overlaps.push_back(loop);
  problem.new_overlaps = {1, 2};
  EXPECT_EQ(DriftOfLoop(problem, loop, {}), 0);
}

}  // namespace
}  // namespace corbslam

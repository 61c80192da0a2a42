// Long drives, of which only poses matter: a keyframe a metre, at a scene's depth of 1.
#include "slam/fusing/loop_drift.h"

#include <gtest/gtest.h>

namespace corbslam {
namespace {

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};
constexpr uint32_t kKeyframes = 200;

// Two local maps of one island: B goes on where A ends.
class LoopDriftTest : public ::testing::Test {
 protected:
  LoopDriftTest() {
    AddDrive(kA, 0);
    AddDrive(kB, kKeyframes);
    request_.overlaps = {Say({kB, 0}, {kA, kKeyframes - 1}, Eigen::Vector3d::Zero())};
  }

  void AddDrive(LocalMapId id, uint32_t start) {
    const auto camera = std::make_shared<const Camera>(Camera{.baseline_m = 0.1});
    for (uint32_t k = 0; k < kKeyframes; ++k) {
      Keyframe keyframe;
      keyframe.payload = MakeKeyframePayload({id, k}, k, 0, camera, {});
      keyframe.camera_from_map.translation = {-double(start + k), 0, 0};
      if (k > 0) keyframe.parent = {id, k - 1};
      request_.target.AddKeyframe(std::move(keyframe));
    }
  }

  // An overlap of two keyframes, wrong by so much.
  Overlap Say(KeyframeId query, KeyframeId candidate, const Eigen::Vector3d& wrong_by,
              double turned_by_rad = 0) const {
    const Map& map = request_.target;
    Rigid3d said = map.FindKeyframe(candidate)->camera_from_map *
                   map.FindKeyframe(query)->camera_from_map.Inverse();
    said.translation += wrong_by;
    said.rotation = Eigen::AngleAxisd(turned_by_rad, Eigen::Vector3d::UnitY()) * said.rotation;
    Overlap overlap;
    overlap.query = query;
    overlap.candidate = candidate;
    overlap.candidate_from_query = Similarity3d::FromRigid(said);
    overlap.verdict = OverlapVerdict::kAccepted;
    return overlap;
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

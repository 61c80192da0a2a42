// Tests matching for triangulation and for fusing on a synthetic scene.
#include <gtest/gtest.h>

#include <memory>

#include "slam/matching/fuse_matching.h"
#include "slam/matching/triangulation_matching.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

class PairMatchingTest : public ::testing::Test {
 protected:
  PairMatchingTest() : scene_(testing::MakeSyntheticScene({.keyframes = 5, .points = 300})) {
    a_ = scene_.map.keyframes().begin()->first;
    b_ = std::next(scene_.map.keyframes().begin())->first;
  }

  // Returns the keyframe as if none of its keypoints saw a point, with all of them under one node.
  Keyframe Unseen(KeyframeId id) const {
    Keyframe keyframe = *scene_.map.FindKeyframe(id);
    NodeFeatures node;
    for (uint32_t i = 0; i < keyframe.points.size(); ++i) node.features.push_back(i);
    auto words = std::make_shared<Words>();
    words->direct_index.push_back(node);
    keyframe.words = words;
    keyframe.points.assign(keyframe.points.size(), MapPointId());
    return keyframe;
  }

  testing::SyntheticScene scene_;
  KeyframeId a_;
  KeyframeId b_;
};

TEST_F(PairMatchingTest, TriangulationPairsSeeTheSamePoint) {
  const auto matches = MatchForTriangulation(Unseen(a_), Unseen(b_));
  ASSERT_GT(matches.size(), 50u);
  for (const auto& [i, j] : matches) {
    EXPECT_EQ(scene_.map.FindKeyframe(a_)->points[i], scene_.map.FindKeyframe(b_)->points[j]);
  }
}

TEST_F(PairMatchingTest, PairsOffTheEpipolarLineAreNone) {
  Keyframe moved = Unseen(b_);
  moved.camera_from_map.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX())) *
      moved.camera_from_map.rotation;
  const size_t right = MatchForTriangulation(Unseen(a_), Unseen(b_)).size();
  EXPECT_LT(MatchForTriangulation(Unseen(a_), moved).size(), right / 5);
}

TEST_F(PairMatchingTest, KeypointsWithPointsAreNotMatchedAgain) {
  Keyframe seen = Unseen(a_);
  seen.points = scene_.map.FindKeyframe(a_)->points;
  EXPECT_TRUE(MatchForTriangulation(seen, Unseen(b_)).empty());
}

TEST_F(PairMatchingTest, FusableFindsALostObservationAndADuplicate) {
  Map map = scene_.map;
  std::vector<MapPointId> shared;
  for (const MapPointId id : map.FindKeyframe(a_)->points) {
    if (id.IsValid() && map.FindPoint(id)->observations.contains(b_)) shared.push_back(id);
  }
  ASSERT_GE(shared.size(), 2u);
  // The first loses its observation in b; the second's there becomes a point of its own.
  const uint32_t lost = map.FindPoint(shared[0])->observations.at(b_);
  const uint32_t doubled = map.FindPoint(shared[1])->observations.at(b_);
  map.RemoveObservation(shared[0], b_);
  map.RemoveObservation(shared[1], b_);
  MapPoint twin = *map.FindPoint(shared[1]);
  twin.id.index = 100000;
  map.AddPoint(twin);
  map.AddObservation(twin.id, b_, doubled);

  const auto proposals = FindFusable(map, *map.FindKeyframe(b_), shared);
  bool found_lost = false;
  bool found_double = false;
  for (const FuseProposal& proposal : proposals) {
    found_lost |=
        proposal.point == shared[0] && proposal.keypoint == lost && !proposal.existing.IsValid();
    found_double |= proposal.point == shared[1] && proposal.existing == twin.id;
  }
  EXPECT_TRUE(found_lost);
  EXPECT_TRUE(found_double);
}

TEST_F(PairMatchingTest, FusableSkipsWhatIsSeenAlreadyOrUnknown) {
  const Keyframe& keyframe = *scene_.map.FindKeyframe(b_);
  std::vector<MapPointId> points = {MapPointId{a_.local_map, 999999}};
  for (const MapPointId id : keyframe.points) {
    if (id.IsValid()) points.push_back(id);
  }
  EXPECT_TRUE(FindFusable(scene_.map, keyframe, points).empty());
}

}  // namespace
}  // namespace corbslam

#include "slam/fusing/map_alignment.h"

#include <gtest/gtest.h>

#include "slam/fusing/duplicate_search.h"
#include "slam/verification/neighbourhood.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam {
namespace {

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};

class MapAlignmentTest : public ::testing::Test {
 protected:
  MapAlignmentTest()
      : world_(testing::MakeRingWorld(3)),
        a_(testing::MakeSyntheticMap(world_, testing::PosesOnRing(0, 3, 6), {.local_map = kA})),
        b_(testing::MakeSyntheticMap(world_, testing::PosesOnRing(4.5, 3, 6), {.local_map = kB})),
        truth_(a_.true_camera_from_world.at({kA, 0}) *
               b_.true_camera_from_world.at({kB, 0}).Inverse()) {}

  // Makes an overlap of keyframe `index` in both maps, with so many points.
  OrientedOverlap MakeOverlap(uint32_t index, size_t points, double error_m = 0) const {
    OrientedOverlap overlap;
    overlap.anchor = {kA, index};
    overlap.mover = {kB, index};
    overlap.anchor_from_mover =
        Similarity3d::FromRigid(a_.true_camera_from_world.at(overlap.anchor) *
                                b_.true_camera_from_world.at(overlap.mover).Inverse());
    overlap.anchor_from_mover.translation.x() += error_m;
    for (const MapPointId& id : a_.map.FindKeyframe(overlap.anchor)->points) {
      if (id.IsValid() && overlap.points.size() < points) overlap.points.emplace_back(id, id);
    }
    return overlap;
  }

  const testing::SyntheticWorld world_;
  const testing::SyntheticMap a_;
  const testing::SyntheticMap b_;
  const Rigid3d truth_;
};

TEST_F(MapAlignmentTest, NothingWithoutOverlaps) {
  EXPECT_FALSE(AlignByConsensus(a_.map, b_.map, {}).has_value());
}

TEST_F(MapAlignmentTest, OneOverlapSaysItAll) {
  const auto found = AlignByConsensus(a_.map, b_.map, {MakeOverlap(2, 20)});
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((found->translation - truth_.translation).norm(), 1e-6);
}

TEST_F(MapAlignmentTest, ManyOutvoteAWrongOneWithMorePoints) {
  const auto found = AlignByConsensus(
      a_.map, b_.map, {MakeOverlap(1, 50, 5.0), MakeOverlap(2, 30), MakeOverlap(3, 25, 0.01)});
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((found->translation - truth_.translation).norm(), 1e-6);
}

TEST_F(MapAlignmentTest, TheQueryMayBeTheAnchor) {
  Overlap overlap;
  overlap.query = {kA, 2};
  overlap.candidate = {kB, 2};
  overlap.candidate_from_query = MakeOverlap(2, 20).anchor_from_mover.Inverse();
  overlap.inliers = {{{kA, 1}, {kB, 7}}};
  const OrientedOverlap oriented = Orient(overlap, /*swap=*/true);
  EXPECT_EQ(oriented.anchor, overlap.query);
  EXPECT_EQ(oriented.points.front().first, (MapPointId{kA, 1}));
  const Similarity3d found = AlignByOverlap(a_.map, b_.map, oriented);
  EXPECT_LT((found.translation - truth_.translation).norm(), 1e-6);
}

TEST_F(MapAlignmentTest, DepthIsTheMedianOfThePoints) {
  const double depth = MedianDepth(a_.map, MakeOverlap(2, 100));
  EXPECT_GT(depth, 1.5);
  EXPECT_LT(depth, 14);
  // An overlap without points takes the depth of those that the anchor sees.
  EXPECT_NEAR(MedianDepth(a_.map, MakeOverlap(2, 0)), depth, 0.5 * depth);
  EXPECT_NE(MedianDepth(a_.map, MakeOverlap(2, 0)), 1);
  EXPECT_EQ(MedianDepth(Map(), MakeOverlap(2, 0)), 1);
}

TEST_F(MapAlignmentTest, PointsThatOneKeyframeSeesApartAreNoDuplicates) {
  // Both neighbourhoods are of one map: a point that is seen twice is one point already.
  const auto anchors = Neighbourhood(a_.map, {kA, 0}, 1);
  const auto movers = Neighbourhood(a_.map, {kA, 5}, 1);
  const Keyframe& first = *a_.map.FindKeyframe({kA, 0});
  std::vector<MapPointId> seen;
  for (const MapPointId& id : first.points) {
    if (id.IsValid()) seen.push_back(id);
  }
  const auto found = FindDuplicates(a_.map, anchors, movers, {{seen[0], seen[1]}});
  for (const auto& [anchor, mover] : found) {
    EXPECT_FALSE(anchor == seen[0] && mover == seen[1]);
  }
}

TEST(OrientTest, TheCovarianceIsThatOfTheOtherDirection) {
  Overlap overlap;
  overlap.candidate_from_query = ExpSim3((Vector7d() << 3, -1, 2, 0.3, -0.5, 0.2, 0.4).finished());
  const Vector7d error = 1e-6 * (Vector7d() << 2, 1, -3, 0.5, -0.4, 0.3, 0.2).finished();
  overlap.covariance = error * error.transpose();
  EXPECT_EQ(Orient(overlap, false).covariance, overlap.covariance);
  const Similarity3d truth = ExpSim3(error) * overlap.candidate_from_query;
  const Vector7d other = LogSim3(truth.Inverse() * overlap.candidate_from_query);
  const Matrix7d expected = other * other.transpose();
  EXPECT_LT((Orient(overlap, true).covariance - expected).norm(), 1e-4 * expected.norm());
}

}  // namespace
}  // namespace corbslam

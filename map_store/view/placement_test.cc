#include "map_store/view/placement.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kMap = {0xa};
constexpr KeyframeId Kf(uint32_t index) { return {kMap, index}; }

Rigid3d PoseAt(double x) { return {Eigen::Quaterniond::Identity(), {-x, 0, 0}}; }
double CentreX(const Similarity3d& camera_from_island) {
  return camera_from_island.Inverse().translation.x();
}

// Keyframes 0, 1, 2, ... at x = index, each the child of the one before.
class PlacementTest : public ::testing::Test {
 protected:
  PlacementTest() : local_map_(AddLocalMap(state_, kMap, "a")) {
    auto camera = std::make_shared<Camera>();
    *camera = {500, 500, 320, 240, 640, 480, 0.1, 4};
    for (uint32_t i = 0; i < 6; ++i) {
      Keyframe keyframe;
      keyframe.payload = MakeKeyframePayload(Kf(i), i, 0, camera, {});
      keyframe.camera_from_map = PoseAt(i);
      if (i > 0) keyframe.parent = Kf(i - 1);
      local_map_.map.AddKeyframe(std::move(keyframe));
    }
  }

  void Place(uint32_t index, double x, double scale = 1) {
    const Rigid3d& local = local_map_.map.FindKeyframe(Kf(index))->camera_from_map;
    Similarity3d pose = Similarity3d::FromRigid(PoseAt(x));
    pose.scale = scale;
    pose.translation *= scale;
    state_.global.keyframes[Kf(index)] = {pose, local, 1};
  }
  double X(uint32_t index, const Unplaced& unplaced = {}) {
    return CentreX(ComputePoses(local_map_, state_.global, unplaced).at(Kf(index)));
  }

  MissionState state_;
  LocalMapState& local_map_;
};

TEST_F(PlacementTest, ALoneMapStandsInItsOwnFrame) { EXPECT_NEAR(X(4), 4, 1e-12); }

TEST_F(PlacementTest, TheNearestPlacedRelativeInTheTreeDecides) {
  Place(1, 11);
  Place(4, 24);
  EXPECT_NEAR(X(0), 10, 1e-12);
  EXPECT_NEAR(X(2), 12, 1e-12);
  EXPECT_NEAR(X(3), 23, 1e-12);
  EXPECT_NEAR(X(5), 25, 1e-12);
  EXPECT_NEAR(X(4, {Kf(4)}), 14, 1e-12) << "as if it were not placed";
}

TEST_F(PlacementTest, FollowsTheRelativesAndNotAFrozenTransform) {
  Place(3, 3);
  EXPECT_NEAR(X(5), 5, 1e-12);
  Place(3, 13);
  EXPECT_NEAR(X(5), 15, 1e-12);
  // The owner moves the child relative to the parent, which the child's pose follows, too.
  local_map_.map.SetPose(Kf(5), PoseAt(5.5));
  EXPECT_NEAR(X(5), 15.5, 1e-12);
}

TEST_F(PlacementTest, ScaleComesFromTheRelative) {
  // Two local units are one of the island's.
  Place(2, 20, 2);
  EXPECT_NEAR(X(4), 21, 1e-12);
  MapPoint point;
  point.id = {kMap, 0};
  point.reference = Kf(4);
  point.position_in_map = {4, 0, 10};
  const IslandPoses poses = ComputePoses(local_map_, state_.global);
  const Eigen::Vector3d x = ComputePosition(point, local_map_, state_.global, poses);
  EXPECT_NEAR(x.x(), 21, 1e-12);
  EXPECT_NEAR(x.z(), 5, 1e-12);
}

TEST_F(PlacementTest, OrphansFollowThePlacedOneBeforeThem) {
  // The tree falls apart: the root is removed, and a keyframe without a parent comes.
  local_map_.map.RemoveKeyframe(Kf(0));
  Keyframe orphan;
  orphan.payload = MakeKeyframePayload(Kf(9), 9, 0, std::make_shared<Camera>(), {});
  orphan.camera_from_map = PoseAt(9);
  local_map_.map.AddKeyframe(std::move(orphan));
  Place(3, 33);
  EXPECT_NEAR(X(9), 39, 1e-12);
  EXPECT_NEAR(X(1), 31, 1e-12);
}

TEST_F(PlacementTest, WithoutAnyPlacedKeyframeItStaysWhereItStood) {
  state_.global.island_from_local[kMap] = {1, Eigen::Quaterniond::Identity(), {100, 0, 0}};
  EXPECT_NEAR(X(2), 102, 1e-12);
}

TEST_F(PlacementTest, RemovedKeyframesChainToTheLiving) {
  local_map_.map.RemoveKeyframe(Kf(5));
  local_map_.map.RemoveKeyframe(Kf(4));
  local_map_.removed_keyframes[Kf(5)] = {Kf(4), PoseAt(-1)};
  local_map_.removed_keyframes[Kf(4)] = {Kf(3), PoseAt(-1)};
  LivingRelative found;
  ASSERT_TRUE(FindLivingRelative(state_, Kf(5), found));
  EXPECT_EQ(found.id, Kf(3));
  EXPECT_NEAR(found.relative_from_id.translation.x(), 2, 1e-12);
  EXPECT_FALSE(FindLivingRelative(state_, Kf(77), found));
  // Owners who contradict themselves end the chain, not the store.
  local_map_.removed_keyframes[Kf(4)] = {Kf(5), PoseAt(-1)};
  EXPECT_FALSE(FindLivingRelative(state_, Kf(5), found));
}

// Keyframe 2, which the point refers to, was culled; keyframe 3 sees the point, too.
TEST_F(PlacementTest, APointWhoseReferenceWasCulledFollowsAnotherThatSeesIt) {
  MapPoint point;
  point.id = {kMap, 0};
  point.position_in_map = {2, 0, 5};
  point.reference = Kf(2);
  point.observations = {{Kf(2), 0}, {Kf(3), 0}};
  EXPECT_EQ(ReferenceOf(point, state_.global), Kf(2));
  state_.global.culled.insert(Kf(2));
  EXPECT_EQ(ReferenceOf(point, state_.global), Kf(3));
  Place(3, 13);
  const IslandPoses poses = ComputePoses(local_map_, state_.global);
  EXPECT_NEAR(ComputePosition(point, local_map_, state_.global, poses).x(), 12, 1e-12);
  const auto placed = Anchor(point, {4, 0, 5}, 1, state_.global, state_.global.keyframes);
  ASSERT_TRUE(placed.has_value());
  EXPECT_EQ(placed->anchor, Kf(3));
  state_.global.points[point.id] = *placed;
  EXPECT_EQ(ComputePosition(point, local_map_, state_.global, poses).x(), 4);
  EXPECT_NEAR(ComputePosition(point, local_map_, state_.global, poses, {Kf(3)}).x(), 12, 1e-12);
  state_.global.culled.insert(Kf(3));
  EXPECT_EQ(ReferenceOf(point, state_.global), Kf(2)) << "nobody is left";
}

}  // namespace
}  // namespace corbslam::map_store

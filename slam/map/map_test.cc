#include "slam/map/map.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "slam/camera/testing/test_camera.h"

namespace corbslam {
namespace {

constexpr LocalMapId kLocalMap{7};

KeyframeId K(uint32_t index) { return {kLocalMap, index}; }
MapPointId P(uint32_t index) { return {kLocalMap, index}; }

Keyframe MakeKeyframe(uint32_t index, uint32_t parent = KeyframeId::kNoIndex) {
  Features features;
  for (int i = 0; i < 40; ++i) {
    features.keypoints.push_back({.x_px = static_cast<float>(10 * i), .y_px = 50});
    features.descriptors.push_back({{static_cast<uint64_t>(i), index, 0, 0}});
  }
  Keyframe keyframe;
  keyframe.payload =
      MakeKeyframePayload(K(index), index * 1000, 0, testing::TestCamera(), features);
  keyframe.camera_from_map.translation.x() = -static_cast<double>(index);
  if (parent != KeyframeId::kNoIndex) keyframe.parent = K(parent);
  return keyframe;
}

MapPoint MakePoint(uint32_t index) {
  MapPoint point;
  point.id = P(index);
  point.position_in_map = {0.1 * index, 0, 5};
  return point;
}

// Keyframes 0 <- 1 <- 2 <- 3 in a chain; points 0..9, each seen by 0 and 1; 5..9 also by 2 and 3.
Map MakeChain() {
  Map map;
  map.AddKeyframe(MakeKeyframe(0));
  for (uint32_t k = 1; k < 4; ++k) map.AddKeyframe(MakeKeyframe(k, k - 1));
  for (uint32_t p = 0; p < 10; ++p) {
    map.AddPoint(MakePoint(p));
    for (uint32_t k = 0; k < (p < 5 ? 2U : 4U); ++k) map.AddObservation(P(p), K(k), p);
  }
  return map;
}

void ExpectConsistent(const Map& map) {
  for (const auto& [id, keyframe] : map.keyframes()) {
    absl::btree_map<KeyframeId, int> shared;
    for (size_t i = 0; i < keyframe.points.size(); ++i) {
      if (!keyframe.points[i].IsValid()) continue;
      const MapPoint* point = map.FindPoint(keyframe.points[i]);
      ASSERT_NE(point, nullptr);
      EXPECT_EQ(point->observations.at(id), i);
      for (const auto& [other, keypoint] : point->observations) {
        if (other != id) ++shared[other];
      }
    }
    EXPECT_EQ(shared, keyframe.covisible) << ToString(id);
    for (const KeyframeId& child : keyframe.children) {
      EXPECT_EQ(map.FindKeyframe(child)->parent, id);
    }
    size_t steps = 0;
    for (const Keyframe* at = &keyframe; at != nullptr; at = map.FindKeyframe(at->parent)) {
      ASSERT_LE(++steps, map.keyframes().size()) << "cycle above " << ToString(id);
    }
  }
}

TEST(MapTest, CountsCovisibility) {
  const Map map = MakeChain();
  ExpectConsistent(map);
  EXPECT_EQ(map.FindKeyframe(K(0))->covisible.at(K(1)), 10);
  EXPECT_EQ(map.FindKeyframe(K(0))->covisible.at(K(3)), 5);
  const auto best = map.BestCovisible(K(0), 2);
  ASSERT_EQ(best.size(), 2U);
  EXPECT_EQ(best[0].id, K(1));
  EXPECT_EQ(best[1].id, K(2));
  EXPECT_TRUE(map.Covisible(K(0), 11).empty());
}

TEST(MapTest, RefusesASecondObservationOfEitherKind) {
  Map map = MakeChain();
  EXPECT_FALSE(map.AddObservation(P(0), K(0), 30)) << "point seen already";
  EXPECT_FALSE(map.AddObservation(P(0), K(2), 5)) << "keypoint taken";
  EXPECT_FALSE(map.AddObservation(P(0), K(2), 40)) << "keypoint out of range";
  EXPECT_FALSE(map.AddObservation(P(99), K(2), 30));
  ExpectConsistent(map);
}

TEST(MapTest, AddsAllThatAKeyframeSeesButWhatItMayNot) {
  Map map = MakeChain();
  // Keypoint 1 of nothing, 2 of an unknown point, 3 and 4 of one point, 5 is taken.
  map.AddObservations(K(2), {P(0), {}, P(99), P(1), P(1), P(2)});
  const std::vector<MapPointId>& points = map.FindKeyframe(K(2))->points;
  EXPECT_EQ(points[0], P(0));
  EXPECT_FALSE(points[1].IsValid());
  EXPECT_FALSE(points[2].IsValid());
  EXPECT_EQ(points[3], P(1));
  EXPECT_FALSE(points[4].IsValid());
  EXPECT_EQ(points[5], P(5));
  ExpectConsistent(map);
  map.AddObservations(K(99), {P(0)});
}

TEST(MapTest, RemovingAnObservationLowersTheWeight) {
  Map map = MakeChain();
  EXPECT_TRUE(map.RemoveObservation(P(9), K(3)));
  EXPECT_FALSE(map.RemoveObservation(P(9), K(3)));
  EXPECT_EQ(map.FindKeyframe(K(0))->covisible.at(K(3)), 4);
  ExpectConsistent(map);
}

TEST(MapTest, ReplacedPointHandsItsObservationsOver) {
  Map map = MakeChain();
  map.RemoveObservation(P(0), K(1));
  EXPECT_TRUE(map.ReplacePoint(P(0), P(9)));
  EXPECT_EQ(map.FindPoint(P(0)), nullptr);
  EXPECT_FALSE(map.FindKeyframe(K(0))->points[0].IsValid()) << "keyframe 0 saw both";
  ExpectConsistent(map);
  map.AddPoint(MakePoint(20));
  map.AddObservation(P(20), K(2), 20);
  EXPECT_TRUE(map.ReplacePoint(P(20), P(1)));
  EXPECT_EQ(map.FindPoint(P(1))->observations.at(K(2)), 20U);
  ExpectConsistent(map);
  EXPECT_FALSE(map.ReplacePoint(P(1), P(1)));
}

TEST(MapTest, RemovedKeyframesChildrenGoToRelatives) {
  Map map = MakeChain();
  EXPECT_TRUE(map.RemoveKeyframe(K(1)));
  ExpectConsistent(map);
  EXPECT_EQ(map.FindKeyframe(K(2))->parent, K(0));
  EXPECT_TRUE(map.RemoveKeyframe(K(0)));
  ExpectConsistent(map);
  EXPECT_FALSE(map.FindKeyframe(K(2))->parent.IsValid()) << "promoted";
  EXPECT_EQ(map.FindKeyframe(K(3))->parent, K(2));
}

// Keyframes that hung on one of another robot would be left behind, or carried along, when either
// map moves as a whole.
TEST(MapTest, RemovedKeyframesChildrenStayInTheirLocalMap) {
  Map map = MakeChain();
  const KeyframeId foreign{{8}, 0};
  Keyframe other = MakeKeyframe(0);
  other.payload =
      MakeKeyframePayload(foreign, 0, 0, testing::TestCamera(), other.payload->features);
  map.AddKeyframe(std::move(other));
  for (uint32_t p = 0; p < 10; ++p) map.AddObservation(P(p), foreign, p);
  // Only keyframe 2 and the other robot's see these points.
  for (uint32_t p = 10; p < 20; ++p) {
    map.AddPoint(MakePoint(p));
    map.AddObservation(P(p), K(2), p);
    map.AddObservation(P(p), foreign, p);
  }
  ASSERT_EQ(map.BestCovisible(K(2), 1).front().id, foreign);
  EXPECT_TRUE(map.RemoveKeyframe(K(1)));
  ExpectConsistent(map);
  EXPECT_EQ(map.FindKeyframe(K(2))->parent, K(0));
}

TEST(MapTest, RemovedRootLeavesOneTree) {
  Map map;
  map.AddKeyframe(MakeKeyframe(0));
  for (uint32_t k = 1; k < 4; ++k) map.AddKeyframe(MakeKeyframe(k, 0));
  EXPECT_TRUE(map.RemoveKeyframe(K(0)));
  ExpectConsistent(map);
  EXPECT_FALSE(map.FindKeyframe(K(1))->parent.IsValid());
  EXPECT_EQ(map.FindKeyframe(K(2))->parent, K(1));
  EXPECT_EQ(map.FindKeyframe(K(3))->parent, K(1));
}

TEST(MapTest, ParentThatWouldMakeACycleIsRefused) {
  Map map = MakeChain();
  EXPECT_FALSE(map.SetParent(K(0), K(3)));
  EXPECT_FALSE(map.SetParent(K(2), K(2)));
  EXPECT_TRUE(map.SetParent(K(3), K(0)));
  ExpectConsistent(map);
}

TEST(MapTest, LoopEdgesAreSymmetricAndGoWithTheirKeyframe) {
  Map map = MakeChain();
  EXPECT_TRUE(map.AddLoopEdge(K(0), K(3)));
  EXPECT_FALSE(map.AddLoopEdge(K(3), K(0)));
  map.RemoveKeyframe(K(3));
  EXPECT_TRUE(map.FindKeyframe(K(0))->loop_edges.empty());
}

TEST(MapTest, AppearanceComesFromTheObservations) {
  Map map = MakeChain();
  map.UpdatePointAppearance(P(5));
  const MapPoint& point = *map.FindPoint(P(5));
  EXPECT_EQ(point.reference, K(0));
  const double distance = point.position_in_map.norm();
  EXPECT_NEAR(point.max_distance, distance, 1e-12);
  EXPECT_NEAR(point.min_distance, distance / std::pow(1.2, 7), 1e-12);
  EXPECT_NEAR(point.normal_in_map.norm(), 1, 1e-12);
  EXPECT_LT(point.normal_in_map.x(), 0) << "the cameras stand to the right of the point";
  EXPECT_EQ(point.descriptor.words[0], 5U);
}

TEST(MapTest, CopyIsDeepAndHasNoObserver) {
  struct Counter : MapObserver {
    void OnPointRemoved(MapPointId) override { ++removed; }
    int removed = 0;
  } counter;
  Map map = MakeChain();
  map.SetObserver(&counter);
  Map copy = map;
  copy.RemovePoint(P(0));
  EXPECT_NE(map.FindPoint(P(0)), nullptr);
  EXPECT_EQ(counter.removed, 0);
  map.RemovePoint(P(0));
  EXPECT_EQ(counter.removed, 1);
}

TEST(MapTest, KeypointsAreReplacedInANewPayload) {
  Map map = MakeChain();
  const auto before = map.FindKeyframe(K(1))->payload;
  std::vector<Keypoint> moved = before->features.keypoints;
  moved[3].y_px = 90;
  ASSERT_TRUE(map.SetKeypoints(K(1), moved));
  const Keyframe& keyframe = *map.FindKeyframe(K(1));
  EXPECT_EQ(keyframe.keypoints(), moved);
  EXPECT_EQ(keyframe.descriptors(), before->features.descriptors);
  EXPECT_EQ(keyframe.points[3], P(3));
  EXPECT_EQ(before->features.keypoints[3].y_px, 50) << "others may have it";

  moved.pop_back();
  EXPECT_FALSE(map.SetKeypoints(K(1), moved));
  EXPECT_FALSE(map.SetKeypoints(K(77), moved));
  EXPECT_EQ(map.FindKeyframe(K(1))->keypoints().size(), 40u);
}

TEST(MapTest, PartHoldsWhatLiesBetweenItsItems) {
  const Map map = MakeChain();
  const Map part = map.CopyPart({K(1), K(2), K(99)}, {P(4), P(5), P(99)});
  ASSERT_EQ(part.keyframes().size(), 2U);
  ASSERT_EQ(part.points().size(), 2U);
  EXPECT_EQ(part.FindPoint(P(4))->observations.size(), 1U);  // Keyframe 0 is left out.
  EXPECT_EQ(part.FindPoint(P(5))->observations.size(), 2U);
  EXPECT_EQ(part.FindKeyframe(K(1))->points[5], P(5));
  EXPECT_FALSE(part.FindKeyframe(K(1))->points[6].IsValid());
  EXPECT_EQ(part.FindKeyframe(K(2))->parent, K(1));
  EXPECT_FALSE(part.FindKeyframe(K(1))->parent.IsValid());
  // The covisibility is the whole map's, though the part has one of their five points.
  EXPECT_EQ(part.FindKeyframe(K(1))->covisible.at(K(2)), 5);
  EXPECT_EQ(part.FindKeyframe(K(1))->covisible.size(), 1U);
  EXPECT_EQ(map.FindPoint(P(4))->observations.size(), 2U);
}

TEST(MapTest, GivenCovisibilityIsNotCounted) {
  Map map(Covisibility::kGiven);
  for (uint32_t k = 0; k < 3; ++k) map.AddKeyframe(MakeKeyframe(k));
  map.AddPoint(MakePoint(0));
  map.AddObservation(P(0), K(0), 0);
  map.AddObservation(P(0), K(1), 0);
  EXPECT_TRUE(map.Covisible(K(0), 1).empty());
  EXPECT_TRUE(map.SetCovisibility(K(0), K(1), 17));
  EXPECT_TRUE(map.SetCovisibility(K(2), K(0), 30));
  EXPECT_FALSE(map.SetCovisibility(K(0), K(0), 5));
  EXPECT_FALSE(map.SetCovisibility(K(0), K(9), 5));
  map.RemoveObservation(P(0), K(1));
  ASSERT_EQ(map.Covisible(K(0)).size(), 2u);
  EXPECT_EQ(map.Covisible(K(0)).front().id, K(2));
  EXPECT_EQ(map.Covisible(K(1)).front().weight, 17);
  map.RemoveKeyframe(K(1));
  EXPECT_EQ(map.Covisible(K(0)).size(), 1u);
  EXPECT_FALSE(MakeChain().SetCovisibility(K(0), K(1), 3)) << "a map that counts";
}

TEST(MapTest, AMovedMapFindsItsItems) {
  Map map = MakeChain();
  const MapPoint* point = map.FindPoint(P(3));
  const Map moved = std::move(map);
  EXPECT_EQ(moved.FindPoint(P(3)), point);
  EXPECT_EQ(moved.FindKeyframe(K(2))->points[7], P(7));
}

TEST(MapTest, ObserverHearsARemovedKeyframesPlaceInTheTree) {
  struct Recorder : MapObserver {
    void OnKeyframeRemoved(KeyframeId id, KeyframeId to, const Rigid3d& motion) override {
      removed = id;
      parent = to;
      parent_from_removed = motion;
    }
    KeyframeId removed, parent;
    Rigid3d parent_from_removed;
  } recorder;
  Map map = MakeChain();
  map.SetObserver(&recorder);
  map.RemoveKeyframe(K(2));
  EXPECT_EQ(recorder.removed, K(2));
  EXPECT_EQ(recorder.parent, K(1));
  EXPECT_NEAR(recorder.parent_from_removed.translation.x(), 1, 1e-12);
}

}  // namespace
}  // namespace corbslam

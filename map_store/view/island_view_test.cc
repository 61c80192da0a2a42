#include "map_store/view/island_view.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "map_store/view/island_covisibility.h"
#include "slam/camera/testing/test_camera.h"

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kMapA = {0xa};
constexpr LocalMapId kMapB = {0xb};
constexpr LocalMapId kElsewhere = {0xc};
constexpr uint32_t kKeypoints = 40;

constexpr KeyframeId Ka(uint32_t index) { return {kMapA, index}; }
constexpr KeyframeId Kb(uint32_t index) { return {kMapB, index}; }
constexpr MapPointId Pa(uint32_t index) { return {kMapA, index}; }
constexpr MapPointId Pb(uint32_t index) { return {kMapB, index}; }

// Two local maps in one island, and a third in another. In each, keyframes 0 to 5 stand in a chain,
// one metre apart; keyframe i sees points 5 i to 5 i + 9 of its local map with keypoints 0 to 9.
class IslandViewTest : public ::testing::Test {
 protected:
  IslandViewTest() {
    for (const LocalMapId& id : {kMapA, kMapB, kElsewhere}) FillLocalMap(id);
    state_.global.island_of[kMapB] = kMapA;
    state_.global.islands.erase(kMapB);
    island().local_maps = {kMapA, kMapB};
    state_.global.island_from_local[kMapB] =
        Similarity3d::FromRigid({Eigen::Quaterniond::Identity(), {0, 100, 0}});
  }

  void FillLocalMap(LocalMapId id) {
    LocalMapState& local_map = AddLocalMap(state_, id, "agent");
    Features features;
    features.keypoints.resize(kKeypoints);
    features.descriptors.resize(kKeypoints);
    for (uint32_t i = 0; i < 6; ++i) {
      Keyframe keyframe;
      keyframe.payload = MakeKeyframePayload({id, i}, i, 0, testing::TestCamera(), features);
      keyframe.camera_from_map = {Eigen::Quaterniond::Identity(), {-1.0 * i, 0, 0}};
      if (i > 0) keyframe.parent = {id, i - 1};
      local_map.map.AddKeyframe(std::move(keyframe));
    }
    for (uint32_t p = 0; p < 35; ++p) {
      MapPoint point;
      point.id = {id, p};
      point.position_in_map = {0.2 * p, 0, 5};
      point.reference = {id, std::min(p / 5, 5u)};
      local_map.map.AddPoint(point);
    }
    for (uint32_t i = 0; i < 6; ++i) {
      for (uint32_t k = 0; k < 10; ++k) {
        local_map.map.AddObservation({id, 5 * i + k}, {id, i}, k);
      }
    }
  }

  // Makes points 0 to 4 of B points 25 to 29 of A; B's keyframe 0 sees A's point 30 as well.
  void Fuse() {
    for (uint32_t p = 0; p < 5; ++p) state_.global.landmarks.Merge(Pa(25 + p), Pb(p));
    state_.FindLocalMap(kMapB)->foreign_observations[Kb(0)][20] = Pa(30);
  }

  Island& island() { return state_.global.islands.at(kMapA); }
  std::map<std::pair<KeyframeId, KeyframeId>, int> Counted() const {
    std::map<std::pair<KeyframeId, KeyframeId>, int> counted;
    UnbrokenRead read;
    const auto pairs = CountCovisibility(state_, state_.global.islands.at(kMapA), read);
    for (const CovisiblePair& pair : *pairs) {
      counted[{pair.a, pair.b}] = pair.weight;
    }
    return counted;
  }

  // Returns a map of the same observations that counts covisibility by itself.
  static Map Recounted(const Map& view) {
    Map counting;
    for (const auto& [id, keyframe] : view.keyframes()) {
      Keyframe copy;
      copy.payload = keyframe.payload;
      counting.AddKeyframe(std::move(copy));
    }
    for (const auto& [id, point] : view.points()) {
      MapPoint copy;
      copy.id = id;
      counting.AddPoint(std::move(copy));
      for (const auto& [keyframe, keypoint] : point.observations) {
        counting.AddObservation(id, keyframe, keypoint);
      }
    }
    return counting;
  }

  Map Whole(Rejected rejected) {
    return TakeWholeSnapshot(state_, island(), {}, rejected, read_).value().view;
  }

  MissionState state_;
  UnbrokenRead read_;
};

TEST_F(IslandViewTest, CovisibilityIsThatOfAMapThatCountsItself) {
  Fuse();
  std::map<std::pair<KeyframeId, KeyframeId>, int> expected;
  const Map counting = Recounted(Whole(Rejected::kLeaveOut));
  for (const auto& [id, keyframe] : counting.keyframes()) {
    for (const auto& [other, weight] : keyframe.covisible) {
      if (id < other) expected[{id, other}] = weight;
    }
  }
  EXPECT_EQ(Counted(), expected);
  // They share 5 landmarks; the keyframe that also sees point 30 shares 6.
  EXPECT_EQ(expected.at({Ka(5), Kb(0)}), 6);
  EXPECT_EQ(expected.at({Ka(4), Kb(0)}), 5);
}

TEST_F(IslandViewTest, APartOfALocalMapIsCovisibleAsItsOwnerCounted) {
  const Map part = BuildPartialView(state_, {Ka(1), Ka(2), Ka(4), {kMapA, 77}}, read_).value();
  ASSERT_EQ(part.keyframes().size(), 3u);
  EXPECT_EQ(part.FindKeyframe(Ka(1))->covisible, (absl::btree_map<KeyframeId, int>{{Ka(2), 5}}));
  EXPECT_TRUE(part.FindKeyframe(Ka(4))->covisible.empty());
  EXPECT_EQ(part.points().size(), 25u);
}

TEST_F(IslandViewTest, WhatLiesInAnotherIslandIsNotCounted) {
  state_.global.landmarks.Merge(Pa(25), {kElsewhere, 0});
  state_.FindLocalMap(kMapB)->foreign_observations[Kb(0)][20] = {kElsewhere, 3};
  for (const auto& [pair, weight] : Counted()) {
    EXPECT_NE(pair.first.local_map, kElsewhere);
    EXPECT_NE(pair.second.local_map, kElsewhere);
    EXPECT_EQ(pair.first.local_map, pair.second.local_map);
  }
}

TEST_F(IslandViewTest, AGraphHasAllKeyframesButOnlyPointsAroundItsCentres) {
  Fuse();
  const Map whole = Whole(Rejected::kLeaveOut);
  const Map graph =
      TakeGraphSnapshot(state_, island(), {}, {Kb(0)}, 1, {Pa(0)}, read_).value().view;
  ASSERT_EQ(graph.keyframes().size(), 12u);
  for (const auto& [id, keyframe] : whole.keyframes()) {
    const Keyframe& other = *graph.FindKeyframe(id);
    EXPECT_EQ(keyframe.parent, other.parent);
    EXPECT_EQ(keyframe.camera_from_map.translation, other.camera_from_map.translation);
  }
  // Points are those that Kb(0) sees, or Ka(5), which sees most with it; point 0 was asked for by
  // name.
  std::set<MapPointId> expected = {Pa(0)};
  for (uint32_t p = 25; p < 35; ++p) expected.insert(Pa(p));
  for (uint32_t p = 5; p < 10; ++p) expected.insert(Pb(p));
  std::set<MapPointId> there;
  for (const auto& [id, point] : graph.points()) {
    there.insert(id);
    if (id == Pa(0)) continue;
    // Each point has all keyframes that see it, near or not.
    EXPECT_EQ(point.observations, whole.FindPoint(id)->observations) << ToString(id);
    EXPECT_EQ(point.position_in_map, whole.FindPoint(id)->position_in_map);
  }
  EXPECT_EQ(there, expected);
  EXPECT_TRUE(graph.FindPoint(Pa(0))->observations.empty());
}

TEST_F(IslandViewTest, ChildrenOfCulledKeyframesHangOnTheirAncestors) {
  state_.global.culled = {Ka(2), Ka(3)};
  UnbrokenRead read;
  const auto whole = TakeWholeSnapshot(state_, island(), {}, Rejected::kLeaveOut, read);
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_EQ(whole->view.FindKeyframe(Ka(3)), nullptr);
  EXPECT_EQ(whole->view.FindKeyframe(Ka(4))->parent, Ka(1));
  EXPECT_EQ(whole->view.FindKeyframe(Ka(5))->parent, Ka(4));
  EXPECT_FALSE(whole->view.FindKeyframe(Ka(0))->parent.IsValid());
}

TEST_F(IslandViewTest, RejectedObservationsAreLeftOutOrTriedAgain) {
  state_.global.rejected[{Ka(2), 0}] = Pa(10);
  const auto sees = [](const Map& view) {
    return view.FindPoint(Pa(10))->observations.contains(Ka(2));
  };
  EXPECT_FALSE(sees(Whole(Rejected::kLeaveOut)));
  EXPECT_TRUE(sees(Whole(Rejected::kTryAgain)));
}

TEST_F(IslandViewTest, CountsWhatItWouldName) {
  Fuse();
  LocalMapState& b = *state_.FindLocalMap(kMapB);
  // Beside the point within the island B sees one in another island, and one that does not exist.
  b.foreign_observations[Kb(0)][21] = {kElsewhere, 3};
  b.foreign_observations[Kb(1)][22] = Pa(1000);
  RejectedObservations& rejected = state_.global.rejected;
  rejected[{Kb(0), 2}] = Pb(2);
  rejected[{Kb(0), 20}] = Pa(30);
  rejected[{Kb(0), 21}] = {kElsewhere, 3};
  // The keyframe sees another point there by now.
  rejected[{Kb(1), 2}] = Pb(2);
  const auto named = [&](KeyframeId id) {
    const LocalMapState& local_map = *state_.FindLocalMap(id.local_map);
    const auto points = ObservedPoints(state_, local_map, *state_.FindKeyframe(id));
    return std::count_if(points.begin(), points.end(), [](MapPointId p) { return p.IsValid(); });
  };
  const auto counted = [&](KeyframeId id) {
    return static_cast<ptrdiff_t>(
        CountObservedPoints(state_, *state_.FindLocalMap(id.local_map), *state_.FindKeyframe(id)));
  };
  for (uint32_t i = 0; i < 6; ++i) {
    EXPECT_EQ(counted(Ka(i)), named(Ka(i))) << i;
    EXPECT_EQ(counted(Kb(i)), named(Kb(i))) << i;
  }
  EXPECT_EQ(counted(Kb(0)), 9) << "ten of its own without one, and its foreign one is rejected";
  EXPECT_EQ(counted(Kb(1)), 10);
}

}  // namespace
}  // namespace corbslam::map_store

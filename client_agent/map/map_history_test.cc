#include "client_agent/map/map_history.h"

#include <gtest/gtest.h>

#include <thread>

#include "client_agent/map/guarded_map.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

class CountingObserver : public MapObserver {
 public:
  void OnKeyframeRemoved(KeyframeId, KeyframeId, const Rigid3d&) override { ++removed; }
  void OnPointReplaced(MapPointId, MapPointId) override { ++replaced; }
  bool MayChangeKeypoints(KeyframeId id) const override { return id.index != told; }
  int removed = 0;
  uint32_t told = 2;
  int replaced = 0;
};

class MapHistoryTest : public ::testing::Test {
 protected:
  MapHistoryTest() : scene_(testing::MakeSyntheticScene({.keyframes = 5, .points = 200})) {
    map_ = scene_.map;
    map_.SetObserver(&history_);
  }

  KeyframeId Keyframe(uint32_t i) const { return {map_.keyframes().begin()->first.local_map, i}; }

  testing::SyntheticScene scene_;
  MapHistory history_;
  Map map_;
};

TEST_F(MapHistoryTest, RemovedKeyframeFollowsItsParent) {
  const Rigid3d before = map_.FindKeyframe(Keyframe(3))->camera_from_map;
  ASSERT_TRUE(map_.RemoveKeyframe(Keyframe(3)));
  const auto after = history_.CameraFromMap(map_, Keyframe(3));
  ASSERT_TRUE(after.has_value());
  EXPECT_LT((after->translation - before.translation).norm(), 1e-9);

  // The parent goes too, and then its own parent moves: all follow.
  ASSERT_TRUE(map_.RemoveKeyframe(Keyframe(2)));
  const Rigid3d shift{Eigen::Quaterniond::Identity(), {1, 2, 3}};
  const Map copy = map_;
  for (const auto& [id, keyframe] : copy.keyframes()) {
    map_.SetPose(id, keyframe.camera_from_map * shift);
  }
  const auto moved = history_.CameraFromMap(map_, Keyframe(3));
  ASSERT_TRUE(moved.has_value());
  EXPECT_LT((moved->translation - (before * shift).translation).norm(), 1e-9);
}

TEST_F(MapHistoryTest, KeypointsOfWhatWasToldStay) {
  const auto moved = [&](uint32_t i) {
    std::vector<Keypoint> keypoints = map_.FindKeyframe(Keyframe(i))->keypoints();
    for (Keypoint& keypoint : keypoints) keypoint.x_px += 1;
    return keypoints;
  };
  EXPECT_TRUE(map_.SetKeypoints(Keyframe(2), moved(2))) << "nobody hears of it";
  CountingObserver observer;
  history_.SetNext(&observer);
  const auto before = map_.FindKeyframe(Keyframe(2))->payload;
  EXPECT_FALSE(map_.SetKeypoints(Keyframe(2), moved(2)));
  EXPECT_EQ(map_.FindKeyframe(Keyframe(2))->payload, before);
  EXPECT_TRUE(map_.SetKeypoints(Keyframe(3), moved(3)));
}

TEST_F(MapHistoryTest, UnknownKeyframeHasNoPose) {
  EXPECT_FALSE(history_.CameraFromMap(map_, Keyframe(77)).has_value());
}

TEST_F(MapHistoryTest, FollowsReplacementsInAChain) {
  auto it = map_.points().begin();
  const MapPointId a = (it++)->first;
  const MapPointId b = (it++)->first;
  const MapPointId c = (it++)->first;
  ASSERT_TRUE(map_.ReplacePoint(a, b));
  ASSERT_TRUE(map_.ReplacePoint(b, c));
  EXPECT_EQ(history_.CurrentPoint(a), c);
  EXPECT_EQ(history_.CurrentPoint(c), c);
}

TEST_F(MapHistoryTest, PassesChangesOn) {
  CountingObserver observer;
  history_.SetNext(&observer);
  auto it = map_.points().begin();
  const MapPointId a = (it++)->first;
  map_.ReplacePoint(a, it->first);
  map_.RemoveKeyframe(Keyframe(4));
  EXPECT_EQ(observer.removed, 1);
  EXPECT_EQ(observer.replaced, 1);
}

TEST(GuardedMapTest, NumbersItemsOnceAndCountsCorrections) {
  GuardedMap map(LocalMapId{7});
  EXPECT_EQ(map.NewKeyframeId(), (KeyframeId{LocalMapId{7}, 0}));
  EXPECT_EQ(map.NewKeyframeId(), (KeyframeId{LocalMapId{7}, 1}));
  EXPECT_EQ(map.NewPointId().index, 0u);
  EXPECT_TRUE(map.IsOwn(KeyframeId{LocalMapId{7}, 9}));
  EXPECT_FALSE(map.IsOwn(KeyframeId{LocalMapId{8}, 9}));
  map.CountCorrection();
  EXPECT_EQ(map.corrections(), 1u);
}

TEST(GuardedMapTest, ReadersSeeWholeWrites) {
  GuardedMap map(LocalMapId{7});
  std::thread writer([&map] {
    for (int i = 0; i < 200; ++i) {
      map.Write([&map](Map& m) {
        for (int k = 0; k < 2; ++k) {
          MapPoint point;
          point.id = map.NewPointId();
          m.AddPoint(point);
        }
      });
    }
  });
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(map.Read([](const Map& m) { return m.points().size() % 2; }), 0u);
  }
  writer.join();
  EXPECT_EQ(map.Read([](const Map& m) { return m.points().size(); }), 400u);
}

TEST(MapHistoryBoundTest, ForgetsTheOldestReplacements) {
  constexpr LocalMapId kMap{5};
  MapHistory history(kMap, /*max_replacements=*/2);
  for (uint32_t i = 0; i < 3; ++i) history.OnPointReplaced({kMap, i}, {kMap, 10 + i});
  EXPECT_EQ(history.CurrentPoint({kMap, 0}), (MapPointId{kMap, 0}));
  EXPECT_EQ(history.CurrentPoint({kMap, 1}), (MapPointId{kMap, 11}));
  // Replaced anew, a point is among the newest, whatever became of it before.
  history.OnPointReplaced({kMap, 1}, {kMap, 21});
  history.OnPointReplaced({kMap, 4}, {kMap, 14});
  EXPECT_EQ(history.CurrentPoint({kMap, 1}), (MapPointId{kMap, 21}));
  EXPECT_EQ(history.CurrentPoint({kMap, 2}), (MapPointId{kMap, 2}));
}

TEST(MapHistoryBoundTest, CountsOwnItemsAsTheyComeAndGo) {
  constexpr LocalMapId kMap{5};
  constexpr LocalMapId kOther{6};
  MapHistory history(kMap);
  Map map;
  map.SetObserver(&history);
  for (const LocalMapId id : {kMap, kOther}) {
    for (uint32_t i = 0; i < 3; ++i) {
      Keyframe keyframe;
      keyframe.payload = MakeKeyframePayload({id, i}, 0, 0, std::make_shared<const Camera>(), {});
      map.AddKeyframe(std::move(keyframe));
      MapPoint point;
      point.id = {id, i};
      map.AddPoint(point);
    }
  }
  const auto expect_counted = [&] {
    OwnItems counted;
    for (const auto& [id, keyframe] : map.keyframes()) counted.keyframes += id.local_map == kMap;
    for (const auto& [id, point] : map.points()) counted.points += id.local_map == kMap;
    EXPECT_EQ(history.own_items().keyframes, counted.keyframes);
    EXPECT_EQ(history.own_items().points, counted.points);
  };
  expect_counted();
  EXPECT_EQ(history.own_items().points, 3);
  for (const LocalMapId id : {kMap, kOther}) {
    map.RemoveKeyframe({id, 1});
    map.RemovePoint({id, 0});
    map.ReplacePoint({id, 1}, {id, 2});
    expect_counted();
  }
  EXPECT_EQ(history.own_items().keyframes, 2);
  EXPECT_EQ(history.own_items().points, 1);
}

}  // namespace
}  // namespace corbslam::client_agent

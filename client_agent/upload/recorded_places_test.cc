// Which movements are told: those that somebody would see.
#include "client_agent/upload/testing/recorded_map.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

// Ten points before a keyframe, 10 m away: half a pixel is a centimetre there.
class RecordedPlacesTest : public RecordedMapTest {
 protected:
  RecordedPlacesTest() {
    map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
    for (uint32_t i = 0; i < 10; ++i) {
      MapPoint point = Point({kOwn, i});
      point.reference = {kOwn, 0};
      point.position_in_map = {i * 0.1, 0, 10};
      map_.AddPoint(point);
      map_.AddObservation(point.id, {kOwn, 0}, i);
    }
    EXPECT_EQ(recorder_.TakeBatch(map_, 10).full_points.size(), 10u);
  }

  void Shift(uint32_t point, double x_m) {
    const Eigen::Vector3d before = map_.FindPoint({kOwn, point})->position_in_map;
    map_.SetPosition({kOwn, point}, before + Eigen::Vector3d(x_m, 0, 0));
  }
};

TEST_F(RecordedPlacesTest, WhatNobodySeesMoveIsNotTold) {
  Shift(3, 0.009);
  Shift(4, 0.011);
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(batch.light_points.size(), 1u);
  EXPECT_EQ(batch.light_points[0].id, (MapPointId{kOwn, 4}));
  // Small motions add up.
  Shift(3, 0.009);
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).light_points.size(), 1u);
}

TEST_F(RecordedPlacesTest, ACorrectionIsToldInPosesAlone) {
  const Rigid3d correction = {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
                              {3, 0.2, -1}};
  map_.SetPose({kOwn, 0}, map_.FindKeyframe({kOwn, 0})->camera_from_map * correction.Inverse());
  for (uint32_t i = 0; i < 10; ++i) {
    map_.SetPosition({kOwn, i}, correction * map_.FindPoint({kOwn, i})->position_in_map);
  }
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  EXPECT_EQ(batch.light_keyframes.size(), 1u);
  EXPECT_TRUE(batch.light_points.empty());
}

TEST_F(RecordedPlacesTest, PointsThatStayWhileTheirKeyframeMovesAreTold) {
  map_.SetPose({kOwn, 0}, {Eigen::Quaterniond::Identity(), {0.1, 0, 0}});
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).light_points.size(), 10u);
}

TEST_F(RecordedPlacesTest, WhoAsksGetsExactPlaces) {
  Shift(3, 0.001);
  recorder_.AskForExactPlaces();
  ASSERT_TRUE(recorder_.HasChanges());
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).light_points.size(), 1u);
  EXPECT_FALSE(recorder_.HasChanges());
  Shift(3, 0.001);
  EXPECT_TRUE(recorder_.TakeBatch(map_, 10).light_points.empty());
}

// A byte is left: one of what matters most goes.
TEST_F(RecordedPlacesTest, WhatMattersMostGoesFirst) {
  const auto take = [this](double bytes) {
    return CountUpdates(recorder_.TakeBatch(map_, BatchAllowance(10, bytes, 1)));
  };
  for (uint32_t k = 1; k <= 3; ++k) map_.AddKeyframe(MakeKeyframe({kOwn, k}, {kOwn, 0}));
  for (uint32_t i = 20; i < 23; ++i) {
    MapPoint point = Point({kOwn, i});
    point.reference = {kOwn, 0};
    map_.AddPoint(point);
  }
  for (uint32_t i = 0; i < 3; ++i) Shift(i, 5);
  for (int i = 0; i < 100; ++i) recorder_.AddTrackedFrame({i, {kOwn, 0}, {}});
  recorder_.AddLostFrame(100);
  // All poses; a keyframe even then.
  EXPECT_EQ(take(1), (UpdateCounts{101, 1, 0, 0}));
  EXPECT_EQ(recorder_.CountUntold(), (UpdateCounts{0, 2, 3, 3}));
  recorder_.AddTrackedFrame({101, {kOwn, 1}, {}});
  recorder_.AddTrackedFrame({102, {kOwn, 3}, {}});
  EXPECT_EQ(take(1), (UpdateCounts{1, 1, 0, 0})) << "a frame waits for its keyframe";
  EXPECT_EQ(take(1), (UpdateCounts{1, 1, 0, 0}));
  EXPECT_EQ(take(100), (UpdateCounts{0, 0, 2, 0}));
  EXPECT_EQ(take(100), (UpdateCounts{0, 0, 1, 3}));
  EXPECT_FALSE(recorder_.HasChanges());
}

// The store hears where it is in the end, once.
TEST_F(RecordedPlacesTest, WhatIsHeldBackIsToldOnce) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 1}, {kOwn, 0}));
  map_.AddKeyframe(MakeKeyframe({kOwn, 2}, {kOwn, 0}));
  for (int i = 0; i < 10; ++i) Shift(4, 1);
  EXPECT_TRUE(recorder_.TakeBatch(map_, BatchAllowance(10, 1, 1)).light_points.empty());
  for (int i = 0; i < 10; ++i) Shift(4, 1);
  EXPECT_TRUE(recorder_.TakeBatch(map_, BatchAllowance(10, 1, 1)).light_points.empty());
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, BatchAllowance(10, 1, 1));
  ASSERT_EQ(batch.light_points.size(), 1u);
  EXPECT_NEAR(batch.light_points[0].position_in_local.x(), 20.4, 1e-9);
  EXPECT_FALSE(recorder_.HasChanges());
}

}  // namespace
}  // namespace corbslam::client_agent

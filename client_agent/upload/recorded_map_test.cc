// What of a map's changes is told, what is refused, and how it is cut into batches.

#include "client_agent/upload/testing/recorded_map.h"

#include <limits>
#include <vector>

#include "client_agent/upload/outbox.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_F(RecordedMapTest, ForeignItemsAreTheirOwnersToTell) {
  map_.AddKeyframe(MakeKeyframe({kForeign, 0}, {}));
  MapPoint point = Point({kForeign, 0});
  map_.AddPoint(point);
  map_.AddObservation(point.id, {kForeign, 0}, 0);
  EXPECT_FALSE(recorder_.HasChanges());
}

TEST_F(RecordedMapTest, UnloadingAForeignPointIsNotRemoval) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  MapPoint point = Point({kForeign, 0});
  map_.AddPoint(point);
  map_.AddObservation(point.id, {kOwn, 0}, 3);
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).observations.size(), 1U);
  map_.RemovePoint(point.id);
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  EXPECT_TRUE(batch.observations.empty());
  EXPECT_TRUE(batch.removed_points.empty());
}

TEST_F(RecordedMapTest, AForeignPointThatComesBackIsNotRemovedFromWhereItWas) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  MapPoint point = Point({kForeign, 0});
  MapPoint other = Point({kForeign, 1});
  map_.AddPoint(point);
  map_.AddPoint(other);
  map_.AddObservation(point.id, {kOwn, 0}, 3);
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).observations.size(), 1U);
  map_.RemovePoint(point.id);
  map_.AddPoint(point);
  map_.AddObservation(other.id, {kOwn, 0}, 4);
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(batch.observations.size(), 1U);
  EXPECT_EQ(batch.observations[0].point, other.id);
  // One that the robot takes back itself is told.
  map_.RemoveObservation(other.id, {kOwn, 0});
  const MapUpdateBatch next = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(next.observations.size(), 1U);
  EXPECT_EQ(next.observations[0].kind, ObservationChange::Kind::kRemoved);
}

TEST_F(RecordedMapTest, APointThatComesBackStandsForItselfAgain) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  MapPoint own = Point({kOwn, 0});
  own.reference = {kOwn, 0};
  MapPoint foreign = Point({kForeign, 0});
  map_.AddPoint(own);
  map_.AddObservation(own.id, {kOwn, 0}, 3);
  map_.AddPoint(foreign);
  recorder_.TakeBatch(map_, 10);
  ASSERT_TRUE(map_.ReplacePoint(foreign.id, own.id));
  map_.AddPoint(foreign);
  ASSERT_TRUE(map_.ReplacePoint(own.id, foreign.id));
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(batch.replacements.size(), 1U);
  EXPECT_EQ(batch.replacements[0].replaced, own.id);
  EXPECT_EQ(batch.replacements[0].survivor, foreign.id);
}

TEST_F(RecordedMapTest, FramesBeyondABatchGoIntoTheNext) {
  for (int i = 0; i < 50000; ++i) {
    recorder_.AddLostFrame(i);
    recorder_.AddTrackedFrame({i, {kOwn, 0}, {}});
  }
  size_t lost = 0;
  size_t tracked = 0;
  for (int batches = 0; batches < 2; ++batches) {
    const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
    EXPECT_LE(batch.lost_frames_ns.size(), 40000U);
    EXPECT_LE(batch.tracked_frames.size(), 40000U);
    lost += batch.lost_frames_ns.size();
    tracked += batch.tracked_frames.size();
  }
  EXPECT_EQ(lost, 50000U);
  EXPECT_EQ(tracked, 50000U);
}

TEST_F(RecordedMapTest, AHugeBacklogGoesUpInBatchesThatAStoreTakes) {
  constexpr uint32_t kMany = 150000;
  constexpr size_t kStoreTakes = 1000000;
  Keyframe keyframe = MakeKeyframe({kOwn, 0}, {});
  for (uint32_t i = 0; i < kMany; ++i) {
    keyframe.payload = MakeKeyframePayload({kOwn, i}, i, 0, keyframe.payload->camera, {});
    keyframe.parent = i == 0 ? KeyframeId() : KeyframeId{kOwn, 0};
    map_.AddKeyframe(keyframe);
  }
  while (!corbslam::client_agent::IsEmpty(recorder_.TakeBatch(map_, kMany))) {
  }
  // The whole map moves, and a long way was tracked meanwhile.
  for (uint32_t i = 0; i < kMany; ++i) {
    map_.SetPose({kOwn, i}, {Eigen::Quaterniond::Identity(), {1, 0, 0}});
    recorder_.AddTrackedFrame({i, {kOwn, i}, {}});
    recorder_.AddTrackedFrame({i, {kOwn, i}, {}});
    recorder_.AddTrackedFrame({i, {kOwn, i}, {}});
  }
  size_t keyframes = 0;
  size_t frames = 0;
  while (true) {
    const MapUpdateBatch batch = recorder_.TakeBatch(map_, 8);
    if (corbslam::client_agent::IsEmpty(batch)) break;
    EXPECT_LT(batch.light_keyframes.size() + batch.tracked_frames.size(), kStoreTakes / 2);
    keyframes += batch.light_keyframes.size();
    frames += batch.tracked_frames.size();
  }
  EXPECT_EQ(keyframes, kMany);
  EXPECT_EQ(frames, 3 * kMany);
}

TEST_F(RecordedMapTest, WhatHasImpossibleValuesIsNotTold) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  Keyframe bad = MakeKeyframe({kOwn, 1}, {kOwn, 0});
  bad.camera_from_map.translation.x() = kNan;
  map_.AddKeyframe(bad);
  map_.AddKeyframe(MakeKeyframe({kOwn, 2}, {kOwn, 1}));
  map_.AddLoopEdge({kOwn, 1}, {kOwn, 0});
  recorder_.AddTrackedFrame({5, {kOwn, 1}, {}});
  recorder_.AddTrackedFrame({6, {kOwn, 0}, {}});
  recorder_.AddTrackedFrame({-7, {kOwn, 0}, {}});
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(batch.full_keyframes.size(), 2u);
  EXPECT_EQ(batch.full_keyframes[1].payload->id, (KeyframeId{kOwn, 2}));
  EXPECT_EQ(batch.full_keyframes[1].parent, (KeyframeId{kOwn, 0})) << "past the one left out";
  EXPECT_TRUE(batch.loop_edges.empty());
  ASSERT_EQ(batch.tracked_frames.size(), 1u);
  EXPECT_EQ(batch.tracked_frames[0].timestamp_ns, 6);
  EXPECT_EQ(recorder_.refused_items(), 2u) << "the keyframe, and the frame before all time";
  EXPECT_FALSE(recorder_.HasChanges());

  // One that was told stays where it was until it has a place again.
  const auto move = [&](double x) {
    map_.SetPose({kOwn, 2}, {Eigen::Quaterniond::Identity(), {x, 0, 0}});
    return recorder_.TakeBatch(map_, 10).light_keyframes;
  };
  EXPECT_TRUE(move(kNan).empty());
  EXPECT_EQ(recorder_.refused_items(), 3u);
  EXPECT_EQ(move(1).size(), 1u);
}

// What comes after it is told all the same, by a batch that is not empty.
TEST_F(RecordedMapTest, WhatIsRefusedTakesNoRoomInABatch) {
  UpdateRecorder recorder(kOwn,
                          {.hold_newest = 0, .limits = {.removed_keyframes = 1, .frames = 1}});
  map_.SetObserver(&recorder);
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  Keyframe bad = MakeKeyframe({kOwn, 1}, {kOwn, 0});
  bad.camera_from_map.translation.x() = std::numeric_limits<double>::quiet_NaN();
  map_.AddKeyframe(bad);
  map_.AddKeyframe(MakeKeyframe({kOwn, 2}, {kOwn, 0}));
  EXPECT_EQ(recorder.TakeBatch(map_, 10).full_keyframes.size(), 2u);

  map_.RemoveKeyframe({kOwn, 1});
  map_.RemoveKeyframe({kOwn, 2});
  recorder.AddTrackedFrame({5, {kOwn, 1}, {}});
  for (const int64_t time_ns : {-7, -6, 8}) recorder.AddLostFrame(time_ns);
  const MapUpdateBatch batch = recorder.TakeBatch(map_, 10);
  ASSERT_EQ(batch.removed_keyframes.size(), 1u);
  EXPECT_EQ(batch.removed_keyframes[0].id, (KeyframeId{kOwn, 2}));
  EXPECT_THAT(batch.lost_frames_ns, ElementsAre(8));
  EXPECT_THAT(batch.tracked_frames, IsEmpty()) << "nobody knows where its keyframe was";
  EXPECT_FALSE(recorder.HasChanges());
}

TEST_F(RecordedMapTest, FramesWaitForTheirReference) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  map_.AddKeyframe(MakeKeyframe({kOwn, 1}, {kOwn, 0}));
  recorder_.AddTrackedFrame({100, {kOwn, 0}, {}});
  recorder_.AddTrackedFrame({200, {kOwn, 1}, {}});
  EXPECT_EQ(recorder_.TakeBatch(map_, 1).tracked_frames.size(), 1U);
  EXPECT_EQ(recorder_.TakeBatch(map_, 1).tracked_frames.size(), 1U);
}

TEST_F(RecordedMapTest, CameraGoesOnceBeforeItsFirstKeyframe) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).cameras.size(), 1U);
  map_.AddKeyframe(MakeKeyframe({kOwn, 1}, {kOwn, 0}));
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).cameras.size(), 0U);
}

TEST(RecordedCameraTest, GoesUpOnceWithItsCamera) {
  RecordedCamera recorded;
  recorded.lens.fx_px = 400;
  recorded.lens.fy_px = 400;
  UpdateRecorder recorder(kOwn, RecorderOptions{.recorded_camera = recorded});
  Map map;
  map.SetObserver(&recorder);
  map.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  const MapUpdateBatch first = recorder.TakeBatch(map, 10);
  ASSERT_EQ(first.cameras.size(), 1u);
  EXPECT_EQ(first.recorded_cameras, std::vector<RecordedCamera>{recorded});
  map.AddKeyframe(MakeKeyframe({kOwn, 1}, {kOwn, 0}));
  EXPECT_TRUE(recorder.TakeBatch(map, 10).recorded_cameras.empty());
}

}  // namespace
}  // namespace corbslam::client_agent

// Tests that the newest keyframes are held back until they are known to last.
#include <vector>

#include "client_agent/upload/outbox.h"
#include "client_agent/upload/testing/recorded_map.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class HeldBackRecorderTest : public ::testing::Test {
 protected:
  HeldBackRecorderTest() { map_.SetObserver(&recorder_); }

  // Adds keyframes, one a tenth of a second; frames come as fast.
  void AddKeyframe(uint32_t index) {
    Keyframe keyframe =
        MakeKeyframe({kOwn, index}, index == 0 ? KeyframeId() : KeyframeId{kOwn, 0});
    keyframe.payload = MakeKeyframePayload({kOwn, index}, TimeOf(index), 0,
                                           keyframe.payload->camera, keyframe.payload->features);
    map_.AddKeyframe(keyframe);
    recorder_.AddTrackedFrame({TimeOf(index), {kOwn, index}, {}});
  }
  static int64_t TimeOf(uint32_t index) { return int64_t{index} * 100'000'000; }
  std::vector<uint32_t> TakeKeyframes() {
    std::vector<uint32_t> taken;
    const MapUpdateBatch batch = recorder_.TakeBatch(map_, 100);
    for (const FullKeyframe& full : batch.full_keyframes) taken.push_back(full.payload->id.index);
    frames_ += batch.tracked_frames.size();
    return taken;
  }

  UpdateRecorder recorder_{kOwn,
                           RecorderOptions{.hold_newest = 3, .hold_at_most_ns = 3'000'000'000}};
  Map map_;
  size_t frames_ = 0;
};

TEST_F(HeldBackRecorderTest, TheFirstGoesAtOnceTheNewestWait) {
  AddKeyframe(0);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  for (uint32_t i = 1; i < 4; ++i) AddKeyframe(i);
  EXPECT_THAT(TakeKeyframes(), IsEmpty());
  EXPECT_EQ(frames_, 1u) << "frames wait with their keyframes";
  AddKeyframe(4);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(1));
  EXPECT_EQ(frames_, 2u);
}

TEST_F(HeldBackRecorderTest, WhatIsTakenOutMeanwhileIsNeverTold) {
  for (uint32_t i = 0; i < 4; ++i) AddKeyframe(i);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  map_.RemoveKeyframe({kOwn, 2});
  AddKeyframe(4);
  EXPECT_THAT(TakeKeyframes(), IsEmpty()) << "1, 3 and 4 are the newest";
  AddKeyframe(5);
  AddKeyframe(6);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(1, 3));
}

TEST_F(HeldBackRecorderTest, WhoHangsOnOneThatWaitsIsToldOnceNowAndOnceThen) {
  for (uint32_t i = 0; i < 5; ++i) AddKeyframe(i);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0, 1));
  ASSERT_TRUE(map_.SetParent({kOwn, 1}, {kOwn, 4}));
  const MapUpdateBatch now = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(now.light_keyframes.size(), 1u);
  EXPECT_EQ(now.light_keyframes[0].parent, (KeyframeId{kOwn, 0}));
  EXPECT_TRUE(client_agent::IsEmpty(recorder_.TakeBatch(map_, 10)));
  recorder_.StopHoldingBack();
  const MapUpdateBatch then = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(then.light_keyframes.size(), 1u);
  EXPECT_EQ(then.light_keyframes[0].parent, (KeyframeId{kOwn, 4}));
}

TEST_F(HeldBackRecorderTest, KeypointsStayOnceTheyAreTold) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  EXPECT_TRUE(recorder_.MayChangeKeypoints({kOwn, 0}));
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  EXPECT_FALSE(recorder_.MayChangeKeypoints({kOwn, 0}));
  EXPECT_TRUE(recorder_.MayChangeKeypoints({kOwn, 1}));
  std::vector<Keypoint> keypoints = map_.FindKeyframe({kOwn, 1})->keypoints();
  keypoints[4].x_px = 44;
  EXPECT_TRUE(map_.SetKeypoints({kOwn, 1}, keypoints));
  recorder_.StopHoldingBack();
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 9);
  ASSERT_EQ(batch.full_keyframes.size(), 2u);
  EXPECT_EQ(batch.full_keyframes[0].payload->features.keypoints[4].x_px, 44);
}

TEST_F(HeldBackRecorderTest, NoneWaitsForLong) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  recorder_.AddTrackedFrame({TimeOf(31), {kOwn, 2}, {}});
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  recorder_.AddLostFrame(TimeOf(32));
  EXPECT_THAT(TakeKeyframes(), ElementsAre(1));
}

TEST_F(HeldBackRecorderTest, NothingWaitsWhereNoFramesCome) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  recorder_.StopHoldingBack();
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0, 1, 2));
  AddKeyframe(3);
  EXPECT_THAT(TakeKeyframes(), IsEmpty());
}

TEST_F(HeldBackRecorderTest, PointsThatMoveOnAreToldOnceInAWhile) {
  AddKeyframe(0);
  MapPoint point;
  point.id = {kOwn, 0};
  point.position_in_map = {0, 0, 5};
  point.reference = {kOwn, 0};
  map_.AddPoint(point);
  map_.AddObservation(point.id, {kOwn, 0}, 0);
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).full_points.size(), 1u);
  const auto move_and_take = [&](double x, int64_t frame_ns) {
    map_.SetPosition(point.id, {x, 0, 5});
    recorder_.AddTrackedFrame({frame_ns, {kOwn, 0}, {}});
    return recorder_.TakeBatch(map_, 9).light_points;
  };
  EXPECT_EQ(move_and_take(0.1, TimeOf(1)).size(), 1u);
  EXPECT_THAT(move_and_take(0.2, TimeOf(2)), IsEmpty());
  EXPECT_THAT(move_and_take(0.3, TimeOf(20)), IsEmpty());
  const std::vector<LightMapPoint> told = move_and_take(0.4, TimeOf(21));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].position_in_local.x(), 0.4);
  // A clock that was set back.
  EXPECT_EQ(move_and_take(0.5, TimeOf(0)).size(), 1u);
  EXPECT_THAT(move_and_take(0.6, TimeOf(1)), IsEmpty());
  recorder_.AskForExactPlaces();
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).light_points.size(), 1u);
  EXPECT_THAT(move_and_take(0.7, TimeOf(2)), IsEmpty());
  recorder_.StopHoldingBack();
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).light_points.size(), 1u);
}

TEST_F(HeldBackRecorderTest, WhoAsksForExactPlacesIsToldAll) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  recorder_.AskForExactPlaces();
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0, 1, 2));
}

TEST_F(HeldBackRecorderTest, WhatCanNeverBeToldKeepsNothingExact) {
  AddKeyframe(0);
  // Only another's keyframe sees it.
  map_.AddKeyframe(MakeKeyframe({kForeign, 0}, {}));
  MapPoint point;
  point.id = {kOwn, 0};
  point.reference = {kForeign, 0};
  map_.AddPoint(point);
  map_.AddObservation(point.id, {kForeign, 0}, 0);
  recorder_.AskForExactPlaces();
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  EXPECT_TRUE(recorder_.HasChanges());
  EXPECT_THAT(TakeKeyframes(), IsEmpty());
  for (uint32_t i = 1; i < 4; ++i) AddKeyframe(i);
  EXPECT_THAT(TakeKeyframes(), IsEmpty()) << "held back again";
}

}  // namespace
}  // namespace corbslam::client_agent

#include "client_agent/loop_closing/correction_view.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "slam/fusing/map_fusing.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{0xa};
constexpr LocalMapId kOther{0xb};
constexpr uint32_t kKeyframes = 30;

// Keyframes of the own robot and of another stand side by side: those of a number see points of
// that number and the next one's, of both robots.
Map TwoRobotsSideBySide() {
  Map map;
  for (const LocalMapId id : {kOwn, kOther}) {
    for (uint32_t k = 0; k < kKeyframes; ++k) {
      auto payload = std::make_shared<KeyframePayload>();
      payload->id = {id, k};
      payload->features.keypoints.resize(4);
      payload->features.descriptors.resize(4);
      Keyframe keyframe;
      keyframe.payload = std::move(payload);
      if (k > 0) keyframe.parent = {id, k - 1};
      map.AddKeyframe(std::move(keyframe));
    }
    for (uint32_t p = 0; p < kKeyframes; ++p) {
      MapPoint point;
      point.id = {id, p};
      point.reference = {id, p};
      map.AddPoint(point);
    }
  }
  for (const LocalMapId id : {kOwn, kOther}) {
    for (uint32_t k = 0; k < kKeyframes; ++k) {
      map.AddObservation({kOwn, k}, {id, k}, 0);
      map.AddObservation({kOther, k}, {id, k}, 1);
      if (k == 0) continue;
      map.AddObservation({kOwn, k - 1}, {id, k}, 2);
      map.AddObservation({kOther, k - 1}, {id, k}, 3);
    }
  }
  return map;
}

TEST(CorrectionViewTest, HasAllThatIsOwnAndNoKeyframeOfOthersWithoutALoopAgainstThem) {
  const Map map = TwoRobotsSideBySide();
  const Map view = CorrectionView(map, kOwn, KeyframeId{kOwn, 3});
  EXPECT_EQ(view.keyframes().size(), kKeyframes);
  EXPECT_NE(view.FindKeyframe({kOwn, 29}), nullptr);
  EXPECT_EQ(view.FindPoint({kOwn, 5})->observations.size(), 2U);
}

TEST(CorrectionViewTest, HasOthersWhereALoopEndsAndWhatTheySeeThere) {
  const Map map = TwoRobotsSideBySide();
  const Map view = CorrectionView(map, kOwn, KeyframeId{kOther, 20});
  for (const uint32_t k : {19U, 20U, 21U}) {
    EXPECT_NE(view.FindKeyframe({kOther, k}), nullptr) << k;
    EXPECT_NE(view.FindPoint({kOther, k}), nullptr) << k;
  }
  EXPECT_EQ(view.FindKeyframe({kOther, 25}), nullptr);
  EXPECT_EQ(view.FindPoint({kOwn, 25})->observations.size(), 2U) << "own keyframes see it";
  EXPECT_EQ(view.FindPoint({kOther, 20})->observations.size(), 4U) << "all of both robots";
}

TEST(CorrectionViewTest, WhatOwnKeyframesAloneSeeGoesWithThem) {
  const Map map = TwoRobotsSideBySide();
  const Map view = CorrectionView(map, kOwn, KeyframeId{kOther, 20});
  const MapPoint& elsewhere = *view.FindPoint({kOther, 5});
  EXPECT_EQ(elsewhere.reference, (KeyframeId{kOwn, 5}));
  EXPECT_TRUE(MovesWith(kOwn, elsewhere));
  const MapPoint& held = *view.FindPoint({kOther, 20});
  EXPECT_EQ(held.reference, (KeyframeId{kOther, 20}));
  EXPECT_FALSE(MovesWith(kOwn, held));
}

TEST(CorrectionViewTest, HasTheEndsOfEarlierLoops) {
  Map map = TwoRobotsSideBySide();
  ASSERT_TRUE(map.AddLoopEdge({kOwn, 9}, {kOther, 8}));
  const Map view = CorrectionView(map, kOwn, std::nullopt);
  EXPECT_NE(view.FindKeyframe({kOther, 8}), nullptr);
  EXPECT_TRUE(view.FindKeyframe({kOwn, 9})->loop_edges.contains({kOther, 8}));
  EXPECT_EQ(view.FindKeyframe({kOther, 20}), nullptr);
}

}  // namespace
}  // namespace corbslam::client_agent

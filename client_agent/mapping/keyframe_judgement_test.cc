#include "client_agent/mapping/keyframe_judgement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client_agent/map/provisional_keyframes.h"
#include "client_agent/mapping/keyframe_insertion.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr LocalMapId kOwn{0x5ce7e};

// Eight keyframes in a row, all of which see nearly the same.
class KeyframeJudgementTest : public ::testing::Test {
 protected:
  KeyframeJudgementTest() : map_(kOwn) {
    testing::SyntheticSceneOptions options;
    options.keyframes = 8;
    options.points = 400;
    options.step_m = 0.01;
    scene_ = testing::MakeSyntheticScene(options).map;
  }

  // The points that keyframe `from` sees are hidden from keyframe `id`, but for a share of them.
  void Hide(uint32_t id, uint32_t from, double share) {
    const std::vector<MapPointId> points = scene_.FindKeyframe({kOwn, from})->points;
    int count = 0;
    for (const MapPointId point : points) {
      if (!point.IsValid()) continue;
      if (++count % 100 >= 100 * share) scene_.RemoveObservation(point, {kOwn, id});
    }
  }
  void CopyToGuarded() {
    map_.Write([&](Map& map) {
      // Observers hear of nothing that happens to the scene.
      for (const auto& [id, keyframe] : scene_.keyframes()) {
        Keyframe copy = keyframe;
        copy.points.assign(copy.points.size(), MapPointId());
        copy.covisible.clear();
        copy.children.clear();
        map.AddKeyframe(copy);
      }
      for (const auto& [id, point] : scene_.points()) {
        MapPoint copy = point;
        copy.observations.clear();
        map.AddPoint(copy);
        for (const auto& [keyframe, keypoint] : point.observations) {
          map.AddObservation(id, keyframe, keypoint);
        }
      }
    });
  }

  Map scene_;
  GuardedMap map_;
};

TEST_F(KeyframeJudgementTest, SpannedIsWhoseNeighboursSeeTheSame) {
  EXPECT_TRUE(IsSpanned(scene_, {kOwn, 3}));
  Hide(/*id=*/4, /*from=*/2, /*share=*/0.6);
  EXPECT_FALSE(IsSpanned(scene_, {kOwn, 3}));
}

TEST_F(KeyframeJudgementTest, TheFirstTheLastAndThoseOfLoopsStay) {
  EXPECT_FALSE(IsSpanned(scene_, {kOwn, 0}));
  EXPECT_FALSE(IsSpanned(scene_, {kOwn, 7}));
  EXPECT_FALSE(IsSpanned(scene_, {kOwn, 99}));
  scene_.AddLoopEdge({kOwn, 3}, {kOwn, 6});
  EXPECT_FALSE(IsSpanned(scene_, {kOwn, 3}));
}

TEST_F(KeyframeJudgementTest, OthersKeyframesAreNoNeighbours) {
  Map map;
  // Between which an own one stands alone.
  for (const KeyframeId id : {KeyframeId{LocalMapId{kOwn.value - 1}, 0}, KeyframeId{kOwn, 3},
                              KeyframeId{LocalMapId{kOwn.value + 1}, 0}}) {
    Keyframe keyframe = *scene_.FindKeyframe({kOwn, 3});
    keyframe.payload =
        MakeKeyframePayload(id, 0, 0, keyframe.payload->camera, keyframe.payload->features);
    keyframe.points.assign(keyframe.points.size(), MapPointId());
    keyframe.covisible.clear();
    keyframe.children.clear();
    keyframe.parent = {LocalMapId{kOwn.value - 1}, 0};
    ASSERT_TRUE(map.AddKeyframe(keyframe));
  }
  EXPECT_FALSE(IsSpanned(map, {kOwn, 3}));
}

TEST_F(KeyframeJudgementTest, JudgesWhatLeavesTheNewestOnce) {
  CopyToGuarded();
  KeyframeJudge judge;
  // Of eight the newest five are provisional, and the first stays.
  EXPECT_THAT(judge.Judge(map_), ElementsAre(KeyframeId{kOwn, 1}, KeyframeId{kOwn, 2}));
  EXPECT_THAT(judge.Judge(map_), IsEmpty());
  map_.Read([](const Map& map) {
    EXPECT_EQ(map.keyframes().size(), 1 + kProvisionalKeyframes);
    for (const auto& [id, point] : map.points()) EXPECT_GT(CountObservations(map, point), 1);
  });
}

TEST_F(KeyframeJudgementTest, WhatWasWorthKeepingIsNotJudgedAgain) {
  Hide(/*id=*/2, /*from=*/0, /*share=*/0.5);
  Hide(/*id=*/3, /*from=*/1, /*share=*/0.5);
  CopyToGuarded();
  KeyframeJudge judge;
  EXPECT_THAT(judge.Judge(map_), IsEmpty());
  map_.Write([](Map& map) { map.RemoveKeyframe({kOwn, 3}); });
  EXPECT_THAT(judge.Judge(map_), IsEmpty());
}

}  // namespace
}  // namespace corbslam

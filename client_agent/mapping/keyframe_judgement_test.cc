#include "client_agent/mapping/keyframe_judgement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "client_agent/map/provisional_keyframes.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr LocalMapId kOwn{0x5ce7e};

// Ten keyframes in a row, all of which see nearly the same.
class KeyframeJudgementTest : public ::testing::Test {
 protected:
  KeyframeJudgementTest() : map_(kOwn) {
    testing::SyntheticSceneOptions options;
    options.keyframes = 10;
    options.points = 400;
    options.step_m = 0.01;
    const Map scene = testing::MakeSyntheticScene(options).map;
    map_.Write([&](Map& map) { map = scene; });
  }

  size_t CountKeyframes() const {
    return map_.Read([](const Map& map) { return map.keyframes().size(); });
  }

  GuardedMap map_;
};

TEST_F(KeyframeJudgementTest, JudgesWhatLeavesTheNewestOnceAndNotTheRoot) {
  KeyframeJudge judge;
  EXPECT_THAT(judge.Judge(map_),
              ElementsAre(KeyframeId{kOwn, 1}, KeyframeId{kOwn, 2}, KeyframeId{kOwn, 3}));
  EXPECT_EQ(CountKeyframes(), 1 + kProvisionalKeyframes);
  EXPECT_THAT(judge.Judge(map_), IsEmpty());
}

TEST_F(KeyframeJudgementTest, WhatWasWorthKeepingIsNotJudgedAgain) {
  // Keyframes after number 3 lose sight of what number 2 sees.
  std::vector<std::pair<MapPointId, KeyframeId>> others;
  map_.Write([&](Map& map) {
    for (const MapPointId id : map.FindKeyframe({kOwn, 2})->points) {
      const MapPoint* point = map.FindPoint(id);
      if (point == nullptr) continue;
      for (const auto& [keyframe, keypoint] : point->observations) {
        if (keyframe.index > 3) others.emplace_back(id, keyframe);
      }
    }
    for (const auto& [point, keyframe] : others) map.RemoveObservation(point, keyframe);
  });
  KeyframeJudge judge;
  EXPECT_THAT(judge.Judge(map_), ::testing::Not(::testing::Contains(KeyframeId{kOwn, 2})));
  map_.Read([](const Map& map) { EXPECT_NE(map.FindKeyframe({kOwn, 2}), nullptr); });
  EXPECT_THAT(judge.Judge(map_), IsEmpty());
}

TEST_F(KeyframeJudgementTest, ThoseOfLoopsStay) {
  map_.Write([](Map& map) { map.AddLoopEdge({kOwn, 2}, {kOwn, 9}); });
  KeyframeJudge judge;
  EXPECT_THAT(judge.Judge(map_), ElementsAre(KeyframeId{kOwn, 1}, KeyframeId{kOwn, 3}));
}

TEST_F(KeyframeJudgementTest, WhileAllAreNewNoneIsJudged) {
  map_.Write([](Map& map) {
    for (const uint32_t k : {1u, 3u, 5u, 7u}) map.RemoveKeyframe({kOwn, k});
  });
  KeyframeJudge judge;
  EXPECT_THAT(judge.Judge(map_), IsEmpty());
  EXPECT_EQ(CountKeyframes(), 6u);
}

}  // namespace
}  // namespace corbslam::client_agent

#include "client_agent/mapping/keyframe_judgement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "client_agent/map/provisional_keyframes.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

using ::testing::Contains;
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
  EXPECT_THAT(judge.Judge(map_), ::testing::Not(Contains(KeyframeId{kOwn, 2})));
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

// Ten own keyframes, each point seen by three in a row: none is redundant by the own map alone.
testing::SyntheticSceneOptions OnNewGround() {
  testing::SyntheticSceneOptions options;
  options.keyframes = 10;
  options.points = 2000;
  options.step_m = 0.1;
  options.nearest_m = 2;
  options.farthest_m = 4;
  options.max_observations_per_point = 3;
  return options;
}

// Adds keyframes of another robot that see all that each own one, or each third one, sees, from the
// same places.
enum class Pace { kAsDense, kThreeTimesAsFar };

void DriveAfter(const testing::SyntheticSceneOptions& own, LocalMapId other, Pace pace, Map& map) {
  testing::SyntheticSceneOptions options = own;
  options.local_map = other;
  const Map driven = testing::MakeSyntheticScene(options).map;
  for (const auto& [id, keyframe] : driven.keyframes()) {
    if (pace == Pace::kThreeTimesAsFar && id.index % 3 != 0) continue;
    const std::vector<MapPointId> seen = map.FindKeyframe({kOwn, id.index})->points;
    Keyframe added = keyframe;
    added.points.clear();
    added.children.clear();
    added.covisible.clear();
    map.AddKeyframe(std::move(added));
    map.AddObservations(id, seen);
  }
}

class KnownGroundTest : public ::testing::Test {
 protected:
  KnownGroundTest() : map_(kOwn) {}

  void Drive(const testing::SyntheticSceneOptions& own, int drives_of_others,
             Pace pace = Pace::kAsDense) {
    map_.Write([&](Map& map) {
      map = testing::MakeSyntheticScene(own).map;
      for (int i = 0; i < drives_of_others; ++i) {
        DriveAfter(own, LocalMapId{kOwn.value + 1 + static_cast<uint64_t>(i)}, pace, map);
      }
    });
  }
  std::vector<KeyframeId> JudgeAfter(const testing::SyntheticSceneOptions& own, int drives,
                                     Pace pace = Pace::kAsDense) {
    Drive(own, drives, pace);
    return judge_.Judge(map_);
  }

  GuardedMap map_;
  KeyframeJudge judge_;
};

TEST_F(KnownGroundTest, NewGroundIsKept) { EXPECT_THAT(JudgeAfter(OnNewGround(), 0), IsEmpty()); }

TEST_F(KnownGroundTest, WhatAnotherSawThreeTimesGainsByOneLookMore) {
  EXPECT_THAT(JudgeAfter(OnNewGround(), 1), IsEmpty());
}

TEST_F(KnownGroundTest, WhatOthersSawSixTimesNeedsNoKeyframesMore) {
  EXPECT_THAT(JudgeAfter(OnNewGround(), 2), Contains(KeyframeId{kOwn, 1}));
}

TEST_F(KnownGroundTest, WhatAnotherSawOnceGainsByOneLookMore) {
  EXPECT_THAT(JudgeAfter(OnNewGround(), 1, Pace::kThreeTimesAsFar), IsEmpty());
}

TEST_F(KnownGroundTest, WhatTwoDrivesSawOnceEachNeedsNoKeyframesMore) {
  EXPECT_THAT(JudgeAfter(OnNewGround(), 2, Pace::kThreeTimesAsFar), Contains(KeyframeId{kOwn, 1}));
}

TEST_F(KnownGroundTest, TheOwnMapHoldsTogether) {
  // Of what number 1 sees, hardly anything is seen by numbers 0 and 2 both.
  testing::SyntheticSceneOptions sparse = OnNewGround();
  sparse.points = 100;
  EXPECT_THAT(JudgeAfter(sparse, 2), IsEmpty());
}

TEST_F(KnownGroundTest, AtTheEndTheNewestAreJudgedToo) {
  Drive(OnNewGround(), 2);
  judge_.Judge(map_);
  // Every second one: only neighbours see the same.
  EXPECT_THAT(judge_.JudgeNewest(map_), ElementsAre(KeyframeId{kOwn, 5}, KeyframeId{kOwn, 7}));
}

TEST_F(KeyframeJudgementTest, AtTheEndTheNewestOfNewGroundStay) {
  KeyframeJudge judge;
  judge.Judge(map_);
  EXPECT_THAT(judge.JudgeNewest(map_), IsEmpty());
  EXPECT_EQ(CountKeyframes(), 1 + kProvisionalKeyframes);
}

}  // namespace
}  // namespace corbslam::client_agent

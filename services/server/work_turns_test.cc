#include "services/server/work_turns.h"

#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

const absl::Time kStart = absl::UnixEpoch();

class WorkTurnsTest : public ::testing::Test {
 protected:
  void Add(const std::string& mission, bool may_wait = false, absl::Time now = kStart) {
    turns_.Add({++ids_, mission, may_wait}, now);
  }
  // Begins all that waits, each when the one before has ended.
  std::string WorkAll(absl::Time now = kStart) {
    std::string order;
    while (turns_.waiting() > 0) {
      const WorkTurns::Request request = turns_.Begin(now);
      absl::StrAppend(&order, order.empty() ? "" : " ", request.mission, request.id);
      turns_.End(request.mission);
    }
    return order;
  }

  WorkTurns turns_;
  uint64_t ids_ = 0;
};

TEST_F(WorkTurnsTest, OneMissionsRequestsGoInTheirOrder) {
  for (int i = 0; i < 3; ++i) Add("a");
  EXPECT_EQ(WorkAll(), "a1 a2 a3");
}

TEST_F(WorkTurnsTest, WhoAsksForLittleWaitsForOneRequestOfEachOther) {
  for (int i = 0; i < 4; ++i) Add("a");
  Add("b");
  Add("c");
  EXPECT_EQ(WorkAll(), "a1 b5 c6 a2 a3 a4");
}

TEST_F(WorkTurnsTest, WhatIsWorkedOnCounts) {
  Add("a");
  EXPECT_EQ(turns_.Begin(kStart).mission, "a");
  Add("b");
  EXPECT_EQ(turns_.Begin(kStart).mission, "b");
  turns_.End("b");
  // The turn of b was later, but one of a is still worked on.
  Add("a");
  Add("b");
  EXPECT_EQ(turns_.Begin(kStart).mission, "b");
}

TEST_F(WorkTurnsTest, AdjustmentsStandBackButNotForever) {
  Add("a", true);
  Add("b");
  Add("b");
  EXPECT_EQ(WorkAll(), "b2 b3 a1");
  Add("a", true);
  // Somebody asks again and again.
  absl::Time now = kStart;
  int turns_of_b = 0;
  while (turns_.waiting() > 0) {
    Add("b", false, now);
    const WorkTurns::Request request = turns_.Begin(now);
    turns_.End(request.mission);
    if (request.mission == "a") break;
    ++turns_of_b;
    now += absl::Seconds(1);
  }
  EXPECT_EQ(turns_of_b, 10);
}

TEST_F(WorkTurnsTest, AdjustmentsThatHaveWaitedComeAfterEveryFourthOfTheOthers) {
  for (int i = 0; i < 3; ++i) Add("a", true);
  for (int i = 0; i < 10; ++i) Add("b");
  EXPECT_EQ(WorkAll(kStart + absl::Minutes(1)), "b4 b5 b6 b7 a1 b8 b9 b10 b11 a2 b12 b13 a3");
}

TEST_F(WorkTurnsTest, AHundredMissionsHaveEachTheirTurnWithinAHundred) {
  for (int i = 0; i < 50; ++i) Add("greedy");
  for (int i = 0; i < 100; ++i) Add(absl::StrCat("m", i));
  int seen = 0;
  for (int i = 0; i < 101; ++i) {
    const WorkTurns::Request request = turns_.Begin(kStart);
    turns_.End(request.mission);
    seen += request.mission != "greedy";
  }
  EXPECT_EQ(seen, 100);
}

}  // namespace
}  // namespace corbslam::services

// Tests which moments a replay tells, and how much of them.
#include "map_store/view/map_replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

absl::Status EnoughMemory(uint64_t) { return absl::OkStatus(); }

// A mission without a map: only its numbers count.
MissionState At(uint64_t revision, uint64_t version) {
  MissionState state;
  state.global.revision = revision;
  state.version = version;
  return state;
}

// Returns the revisions that are told of those from `first` to `last`, each with a batch before.
std::vector<uint64_t> Told(uint64_t first, uint64_t last, size_t max_moments) {
  MapReplay replay({.max_moments = max_moments}, {last, 0}, &EnoughMemory);
  uint64_t version = 0;
  for (uint64_t revision = first; revision <= last; ++revision) {
    EXPECT_TRUE(replay.Note(At(revision, ++version)).ok());
    EXPECT_TRUE(replay.Note(At(revision, ++version)).ok());
  }
  EXPECT_TRUE(replay.End(At(last, ++version)).ok());
  std::vector<uint64_t> told;
  for (const MapChanges& changes : std::move(replay).Take()) {
    EXPECT_FALSE(changes.continues);
    told.push_back(changes.revision);
  }
  return told;
}

TEST(MapReplayTest, TellsEachRevisionIfThereAreFew) {
  EXPECT_THAT(Told(0, 4, 5), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(Told(7, 9, 100), ElementsAre(7, 8, 9));
}

TEST(MapReplayTest, SpreadsWhatItTellsOfMany) {
  EXPECT_THAT(Told(0, 100, 5), ElementsAre(0, 25, 50, 75, 100));
  EXPECT_THAT(Told(3, 10, 4), ElementsAre(3, 5, 7, 10));
  EXPECT_THAT(Told(0, 5, 5), ElementsAre(0, 1, 2, 3, 5));
  EXPECT_THAT(Told(5, 900, 2), ElementsAre(5, 900));
  for (size_t most = 2; most <= 60; ++most) {
    const auto told = Told(11, 61, most);
    EXPECT_EQ(told.size(), std::min<size_t>(most, 51));
    EXPECT_EQ(told.front(), 11u);
    EXPECT_EQ(told.back(), 61u);
  }
}

TEST(MapReplayTest, WhatHasNoRevisionsIsToldAtItsBeginningAndEnd) {
  EXPECT_THAT(Told(0, 0, 2), ElementsAre(0, 0));
}

TEST(MapReplayTest, TellsTheNextOneWhereOneIsLeftOut) {
  MapReplay replay({.max_moments = 3}, {10, 0}, &EnoughMemory);
  for (const uint64_t revision : {0u, 7u, 8u}) {
    EXPECT_TRUE(replay.Note(At(revision, revision + 1)).ok());
  }
  EXPECT_TRUE(replay.End(At(10, 20)).ok());
  std::vector<uint64_t> told;
  for (const MapChanges& changes : std::move(replay).Take()) told.push_back(changes.revision);
  EXPECT_THAT(told, ElementsAre(0, 7, 10));
}

// Returns the told moments of a mission with three batches before each revision, as hundreds for
// revisions and ones for batches.
std::vector<uint64_t> ToldOfAll(uint64_t revisions, size_t max_moments) {
  std::vector<ReplayProgress> moments = {{0, 0}};
  for (uint64_t revision = 0; revision < revisions; ++revision) {
    for (uint64_t batch = 1; batch <= 3; ++batch) {
      moments.push_back({revision, 3 * revision + batch});
    }
    moments.push_back({revision + 1, 3 * revision + 3});
  }
  MapReplay replay({.max_moments = max_moments}, moments.back(), &EnoughMemory);
  MissionState state;
  for (const ReplayProgress& moment : moments) {
    state.global.revision = moment.revision;
    state.local_maps[LocalMapId{1}].last_batch = moment.batches;
    ++state.version;
    EXPECT_TRUE(replay.Note(state).ok());
  }
  EXPECT_TRUE(replay.End(state).ok());
  std::vector<uint64_t> told;
  for (const MapChanges& changes : std::move(replay).Take()) {
    const ReplayProgress& moment = moments.at(changes.version - 1);
    told.push_back(100 * moment.revision + moment.batches);
  }
  return told;
}

TEST(EvenStepsTest, ChooseTheEndsFirst) {
  for (const auto& [most, chosen] : std::map<size_t, std::vector<uint64_t>>{
           {0, {}}, {1, {3}}, {2, {3, 9}}, {3, {3, 6, 9}}, {100, {3, 4, 5, 6, 7, 8, 9}}}) {
    EvenSteps steps(3, 9, most);
    std::vector<uint64_t> reached;
    for (uint64_t number = 0; number <= 9; ++number) {
      if (steps.Reach(number)) reached.push_back(number);
    }
    EXPECT_EQ(reached, chosen) << most;
  }
}

TEST(MapReplayTest, TellsBatchesBetweenRevisions) {
  EXPECT_THAT(ToldOfAll(2, 100), ElementsAre(0, 1, 2, 3, 103, 104, 105, 106, 206));
  EXPECT_THAT(ToldOfAll(2, 9), ElementsAre(0, 1, 2, 3, 103, 104, 105, 106, 206));
}

TEST(MapReplayTest, HalfOfWhatItTellsMayBeRevisions) {
  EXPECT_THAT(ToldOfAll(2, 6), ElementsAre(0, 2, 103, 104, 106, 206));
  for (size_t most = 2; most <= 60; ++most) {
    const auto told = ToldOfAll(10, most);
    EXPECT_LE(told.size(), most);
    EXPECT_GE(told.size(), std::min<size_t>(most, 40) * 3 / 4);
    EXPECT_EQ(told.front(), 0u);
    EXPECT_EQ(told.back(), 1030u);
  }
}

TEST(MapReplayTest, NoNumberOfARestoredMissionKeepsItBusy) {
  const uint64_t most = std::numeric_limits<uint64_t>::max();
  EXPECT_THAT(Told(most - 1, most - 1, 1000), ElementsAre(most - 1, most - 1));
  MapReplay replay({.max_moments = 1000}, {3, 0}, &EnoughMemory);
  EXPECT_TRUE(replay.Note(At(most, 1)).ok());
  EXPECT_TRUE(replay.End(At(3, 2)).ok());
}

TEST(MapReplayTest, EndsWhenItIsTooLong) {
  MapReplay replay({.include_points = true, .max_moments = 9, .max_bytes = 3 * sizeof(MapChanges)},
                   {9, 0}, &EnoughMemory);
  for (uint64_t revision = 0; revision < 3; ++revision) {
    EXPECT_TRUE(replay.Note(At(revision, revision + 1)).ok());
  }
  const absl::Status status = replay.Note(At(3, 4));
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("at revision 3 of 9"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("max_moments is 9"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("without points"));
  EXPECT_EQ(replay.status(), status);
  EXPECT_EQ(replay.End(At(9, 10)), status);
}

TEST(MapReplayTest, EndsWhenTheProcessHasNoMemory) {
  MapReplay replay({}, {9, 0}, [](uint64_t bytes) {
    return absl::ResourceExhaustedError(bytes > 0 ? "no memory" : "");
  });
  EXPECT_THAT(std::string(replay.Note(At(0, 1)).message()), HasSubstr("no memory"));
}

TEST(ReplayOptionsTest, NameTheFieldItsValueAndItsLimits) {
  EXPECT_TRUE(ReplayOptions().Validate().ok());
  EXPECT_TRUE(ReplayOptions{.max_moments = 2}.Validate().ok());
  EXPECT_TRUE(ReplayOptions{.max_moments = 1000}.Validate().ok());
  for (const size_t bad : {0u, 1u, 1001u}) {
    const absl::Status status = ReplayOptions{.max_moments = bad}.Validate();
    EXPECT_TRUE(absl::IsInvalidArgument(status));
    EXPECT_EQ(status.message(), "max_moments is " + std::to_string(bad) + ", must be 2 to 1000");
  }
}

}  // namespace
}  // namespace corbslam::map_store

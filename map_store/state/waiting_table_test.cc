#include "map_store/state/waiting_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

struct Note {
  std::string text;
  absl::Time since = absl::InfiniteFuture();

  friend bool operator==(const Note& note, const char* text) { return note.text == text; }
};
using Table = WaitingTable<uint64_t, Note>;

constexpr KeyframeId kKeyframe{LocalMapId{0xa}, 1};
constexpr MapPointId kPoint{LocalMapId{0xa}, 1};
const absl::Time kStart = absl::FromUnixSeconds(1000);

TEST(WaitingTableTest, GivesBackWhatAnItemReleasesInTheOrderOfItsKeys) {
  Table table;
  table.Put(table.NextKey(), {"first"}, kPoint);
  table.Put(table.NextKey(), {"second"}, kKeyframe);
  table.Put(table.NextKey(), {"third"}, kPoint);
  EXPECT_THAT(table.TakeDue(), IsEmpty());
  table.Release(kPoint);
  EXPECT_THAT(table.TakeDue(), ElementsAre(Pair(0, "first"), Pair(2, "third")));
  EXPECT_THAT(table.TakeDue(), IsEmpty());
  EXPECT_EQ(table.size(), 1);
  table.Release(kKeyframe);
  EXPECT_THAT(table.TakeDue(), ElementsAre(Pair(1, "second")));
  EXPECT_EQ(table.size(), 0);
}

TEST(WaitingTableTest, ANewerWordTakesTheOldOnesPlace) {
  Table table;
  table.Put(7, {"old"}, kPoint);
  table.Put(7, {"new"}, kKeyframe);
  table.Release(kPoint);
  EXPECT_THAT(table.TakeDue(), IsEmpty());
  table.Release(kKeyframe);
  EXPECT_THAT(table.TakeDue(), ElementsAre(Pair(7, "new")));
}

TEST(WaitingTableTest, WhatIsErasedIsNotDue) {
  Table table;
  table.Put(1, {"gone"}, kPoint);
  table.Release(kPoint);
  table.Erase(1);
  table.Erase(2);
  EXPECT_THAT(table.TakeDue(), IsEmpty());
}

TEST(WaitingTableTest, AgeCountsFromTheFirstLookAndOutlivesAnotherTry) {
  Table table;
  table.Put(1, {"early"}, kPoint);
  EXPECT_EQ(table.Expire(kStart, absl::Seconds(10)), 0);
  table.Put(2, {"late"}, kPoint);
  EXPECT_EQ(table.Expire(kStart + absl::Seconds(5), absl::Seconds(10)), 0);
  table.Release(kPoint);
  for (const auto& [key, note] : table.TakeDue()) table.Put(key, note, kKeyframe);
  EXPECT_EQ(table.Expire(kStart + absl::Seconds(11), absl::Seconds(10)), 1);
  EXPECT_THAT(table.Values(), ElementsAre(Pair(2, "late")));
  EXPECT_EQ(table.Expire(kStart + absl::Seconds(16), absl::Seconds(10)), 1);
  table.Release(kKeyframe);
  EXPECT_THAT(table.TakeDue(), IsEmpty());
}

TEST(WaitingTableTest, WhatWasReadFromSomewhereIsDue) {
  Table table;
  table.Put(3, {"first", kStart}, kPoint);
  table.Put(5, {"second"}, kPoint);
  Table read(table.Values());
  EXPECT_EQ(read.NextKey(), 6);
  EXPECT_THAT(Table(read).TakeDue(), ElementsAre(Pair(3, "first"), Pair(5, "second")));
  EXPECT_EQ(read.Expire(kStart + absl::Seconds(11), absl::Seconds(10)), 1);
}

}  // namespace
}  // namespace corbslam::map_store

#include "map_store/state/change_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr KeyframeId K(uint32_t index) { return {{0xa}, index}; }
constexpr size_t kMapItems = 10;
constexpr MapPointId P(uint32_t index) { return {{0xa}, index}; }

TEST(ChangeLogTest, SaysWhatCameAfterAVersionEachOnce) {
  ChangeLog log;
  log.NoteKeyframe(K(3));
  log.NotePoint(P(7));
  log.Close(10, kMapItems);
  log.NoteKeyframe(K(2));
  log.NoteKeyframe(K(3));
  log.NoteKeyframe(K(2));
  log.Close(12, kMapItems);
  log.Close(13, kMapItems);  // Nothing was noted for this version.
  EXPECT_THAT(log.Since(9)->keyframes, ElementsAre(K(2), K(3)));
  EXPECT_THAT(log.Since(9)->points, ElementsAre(P(7)));
  EXPECT_THAT(log.Since(10)->keyframes, ElementsAre(K(2), K(3)));
  EXPECT_THAT(log.Since(10)->points, IsEmpty());
  EXPECT_THAT(log.Since(12)->keyframes, IsEmpty());
}

TEST(ChangeLogTest, ForgottenIsNotUnchanged) {
  ChangeLog log;
  log.NoteKeyframe(K(1));
  log.Close(5, kMapItems);
  log.Forget(6);
  EXPECT_FALSE(log.Since(5).has_value());
  log.NoteKeyframe(K(2));
  log.Close(7, kMapItems);
  EXPECT_THAT(log.Since(6)->keyframes, ElementsAre(K(2)));
}

// Moves so many points at each of twenty versions.
ChangeLog MoveAgainAndAgain(uint32_t points, size_t map_items) {
  ChangeLog log;
  for (uint64_t version = 1; version <= 20; ++version) {
    for (uint32_t i = 0; i < points; ++i) log.NotePoint(P(i));
    log.Close(version, map_items);
  }
  return log;
}

TEST(ChangeLogTest, TheOldestGoesWhenThereIsNoRoom) {
  const ChangeLog log = MoveAgainAndAgain(10'000, 1'000'000);
  EXPECT_FALSE(log.Since(9).has_value());
  EXPECT_EQ(log.Since(10)->points.size(), 10'000u);
}

TEST(ChangeLogTest, ASmallMapIsNotRememberedManyTimesOver) {
  const ChangeLog log = MoveAgainAndAgain(1'000, 1'000);
  EXPECT_FALSE(log.Since(15).has_value());
  EXPECT_EQ(log.Since(16)->points.size(), 1'000u);
  EXPECT_LT(log.HeapBytes(), 100'000u);
}

TEST(ChangeLogTest, AFewChangesOfATinyMapAreRemembered) {
  const ChangeLog log = MoveAgainAndAgain(50, 50);
  EXPECT_EQ(log.Since(0)->points.size(), 50u);
}

}  // namespace
}  // namespace corbslam::map_store

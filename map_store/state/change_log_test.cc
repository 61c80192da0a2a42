#include "map_store/state/change_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr KeyframeId K(uint32_t index) { return {{0xa}, index}; }
constexpr MapPointId P(uint32_t index) { return {{0xa}, index}; }

TEST(ChangeLogTest, SaysWhatCameAfterAVersionEachOnce) {
  ChangeLog log;
  log.NoteKeyframe(K(3));
  log.NotePoint(P(7));
  log.Close(10);
  log.NoteKeyframe(K(2));
  log.NoteKeyframe(K(3));
  log.NoteKeyframe(K(2));
  log.Close(12);
  log.Close(13);  // Nothing was noted for this version.
  EXPECT_THAT(log.Since(9)->keyframes, ElementsAre(K(2), K(3)));
  EXPECT_THAT(log.Since(9)->points, ElementsAre(P(7)));
  EXPECT_THAT(log.Since(10)->keyframes, ElementsAre(K(2), K(3)));
  EXPECT_THAT(log.Since(10)->points, IsEmpty());
  EXPECT_THAT(log.Since(12)->keyframes, IsEmpty());
}

TEST(ChangeLogTest, ForgottenIsNotUnchanged) {
  ChangeLog log;
  log.NoteKeyframe(K(1));
  log.Close(5);
  log.Forget(6);
  EXPECT_FALSE(log.Since(5).has_value());
  log.NoteKeyframe(K(2));
  log.Close(7);
  EXPECT_THAT(log.Since(6)->keyframes, ElementsAre(K(2)));
}

TEST(ChangeLogTest, TheOldestGoesWhenThereIsNoRoom) {
  ChangeLog log;
  for (uint64_t version = 1; version <= 20; ++version) {
    for (uint32_t i = 0; i < 10'000; ++i) log.NotePoint(P(i));
    log.Close(version);
  }
  EXPECT_FALSE(log.Since(9).has_value());
  EXPECT_EQ(log.Since(19)->points.size(), 10'000u);
}

}  // namespace
}  // namespace corbslam::map_store

#include "map_store/state/overlap_ledger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};
constexpr LocalMapId kC{0xc};

OverlapEntry Entry(uint64_t id, LocalMapId query, LocalMapId candidate, OverlapState state) {
  OverlapEntry entry;
  entry.id = id;
  entry.overlap.query = {query, 0};
  entry.overlap.candidate = {candidate, 0};
  entry.state = state;
  return entry;
}

TEST(OverlapLedgerTest, FindsWhatIsLiveByStateAndByLocalMaps) {
  OverlapLedger ledger;
  ledger.Add(Entry(1, kA, kB, OverlapState::kWaiting));
  ledger.Add(Entry(2, kB, kA, OverlapState::kInGraph));
  ledger.Add(Entry(3, kB, kC, OverlapState::kInGraph));
  ledger.Add(Entry(4, kA, kB, OverlapState::kRefused));
  ledger.Add(Entry(5, kC, kC, OverlapState::kFailed));
  EXPECT_THAT(ledger.waiting(), ElementsAre(1));
  EXPECT_THAT(ledger.in_graph(), ElementsAre(2, 3));
  EXPECT_THAT(ledger.LiveBetween(kA, kB), ElementsAre(1, 2));
  EXPECT_THAT(ledger.LiveBetween(kB, kA), ElementsAre(1, 2));
  EXPECT_THAT(ledger.LiveBetween(kC, kC), IsEmpty());
  EXPECT_EQ(ledger.entries().size(), 5u);
  EXPECT_EQ(ledger.Find(6), nullptr);
}

TEST(OverlapLedgerTest, ChangesMoveEntries) {
  OverlapLedger ledger;
  ledger.Add(Entry(1, kA, kB, OverlapState::kWaiting));
  ledger.Change(1, [](OverlapEntry& entry) { entry.state = OverlapState::kInGraph; });
  EXPECT_THAT(ledger.waiting(), IsEmpty());
  EXPECT_THAT(ledger.in_graph(), ElementsAre(1));
  EXPECT_THAT(ledger.LiveBetween(kA, kB), ElementsAre(1));
  ledger.Change(1, [](OverlapEntry& entry) { entry.state = OverlapState::kFailed; });
  EXPECT_THAT(ledger.in_graph(), IsEmpty());
  EXPECT_THAT(ledger.LiveBetween(kA, kB), IsEmpty());
  ledger.Change(1, [](OverlapEntry& entry) { entry.state = OverlapState::kWaiting; });
  EXPECT_THAT(ledger.waiting(), ElementsAre(1));
}

TEST(OverlapLedgerTest, FindsWhatIsLiveAtAKeyframe) {
  OverlapLedger ledger;
  ledger.Add(Entry(1, kA, kB, OverlapState::kWaiting));
  ledger.Add(Entry(2, kC, kA, OverlapState::kInGraph));
  ledger.Add(Entry(3, kA, kC, OverlapState::kRefused));
  EXPECT_THAT(ledger.LiveAt({kA, 0}), ElementsAre(1, 2));
  EXPECT_THAT(ledger.LiveAt({kB, 0}), ElementsAre(1));
  EXPECT_THAT(ledger.LiveAt({kA, 1}), IsEmpty());
  ledger.Change(1, [](OverlapEntry& entry) { entry.state = OverlapState::kFailed; });
  EXPECT_THAT(ledger.LiveAt({kA, 0}), ElementsAre(2));
  EXPECT_THAT(ledger.LiveAt({kB, 0}), IsEmpty());
}

TEST(OverlapLedgerTest, IsMadeOfItsEntries) {
  OverlapLedger::Entries entries;
  entries[1] = Entry(1, kA, kB, OverlapState::kInGraph);
  entries[2] = Entry(2, kA, kC, OverlapState::kWaiting);
  const OverlapLedger ledger(entries);
  EXPECT_THAT(ledger.waiting(), ElementsAre(2));
  EXPECT_THAT(ledger.LiveAt({kA, 0}), ElementsAre(1, 2));
  EXPECT_THAT(ledger.LiveBetween(kB, kA), ElementsAre(1));
}

TEST(OverlapLedgerTest, KeepsAllThatIsLiveAndTheNewestOfTheRest) {
  OverlapLedger ledger;
  ledger.Add(Entry(1, kA, kB, OverlapState::kInGraph));
  const uint64_t last = OverlapLedger::kMaxHistory + 11;
  for (uint64_t id = 2; id <= last; ++id) ledger.Add(Entry(id, kA, kB, OverlapState::kRefused));
  EXPECT_EQ(ledger.entries().size(), OverlapLedger::kMaxHistory + 1);
  EXPECT_TRUE(ledger.contains(1));
  EXPECT_FALSE(ledger.contains(11));
  EXPECT_TRUE(ledger.contains(12));
  EXPECT_TRUE(ledger.contains(last));
}

}  // namespace
}  // namespace corbslam::map_store

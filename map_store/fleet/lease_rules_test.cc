#include "map_store/fleet/lease_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace corbslam::map_store {
namespace {

using ::testing::IsEmpty;

DirectoryStore Alive(const std::string& name, uint64_t missions = 0) {
  DirectoryStore store;
  store.name = name;
  store.missions = missions;
  store.lease_left = absl::Seconds(1);
  return store;
}

std::string NameOf(const DirectoryStore* store) { return store == nullptr ? "" : store->name; }

TEST(LeaseRulesTest, AMissionIsTakenByWhoHasItOrOnceItsLeaseIsOver) {
  EXPECT_TRUE(MayTake({1, 1, absl::Seconds(1)}, 1));
  EXPECT_FALSE(MayTake({1, 1, absl::Milliseconds(1)}, 2));
  EXPECT_TRUE(MayTake({1, 1, absl::ZeroDuration()}, 2));
  EXPECT_TRUE(MayWrite({1, 3, absl::ZeroDuration()}, 3));
  EXPECT_FALSE(MayWrite({1, 4, absl::Seconds(9)}, 3));
}

TEST(LeaseRulesTest, AnOwnLeaseCountsFromTheRequest) {
  const absl::Time begin = absl::UnixEpoch();
  OwnLease lease(absl::Seconds(15), begin);
  EXPECT_EQ(lease.between_requests(), absl::Seconds(5));
  EXPECT_FALSE(lease.IsOver(begin + absl::Milliseconds(13499)));
  EXPECT_TRUE(lease.IsOver(begin + absl::Milliseconds(13500)));
  lease.NoteProlonged(begin + absl::Seconds(5));
  EXPECT_FALSE(lease.IsOver(begin + absl::Seconds(18)));
  EXPECT_TRUE(lease.IsOver(begin + absl::Milliseconds(18500)));
}

TEST(LeaseRulesTest, TheFreestIsAnotherOneThatTakesMissions) {
  std::vector<DirectoryStore> stores = {Alive("own"), Alive("a", 3), Alive("b", 1), Alive("c"),
                                        Alive("d")};
  stores[0].is_own = true;
  stores[3].is_cordoned = true;
  stores[4].lease_left = absl::ZeroDuration();
  EXPECT_EQ(NameOf(FindFreest(stores)), "b");
  EXPECT_EQ(FindFreest({stores[0], stores[3], stores[4]}), nullptr);
}

TEST(LeaseRulesTest, AMissionGoesWhereItWasMovedUnlessNobodyTakesItThere) {
  std::vector<DirectoryStore> stores = {Alive("own"), Alive("a", 5), Alive("b", 2)};
  stores[0].is_own = true;
  constexpr auto kTakes = StoreDuty::kTakesMissions;
  EXPECT_EQ(FindTaker(kTakes, "", stores), nullptr);
  EXPECT_EQ(NameOf(FindTaker(kTakes, "a", stores)), "a");
  EXPECT_EQ(FindTaker(kTakes, "own", stores), nullptr);
  EXPECT_EQ(FindTaker(kTakes, "forgotten", stores), nullptr);
  EXPECT_EQ(NameOf(FindTaker(StoreDuty::kCordoned, "", stores)), "b");
  stores[1].is_cordoned = true;
  EXPECT_EQ(FindTaker(kTakes, "a", stores), nullptr);
  stores[2].lease_left = absl::ZeroDuration();
  // Nobody else is there: it serves on.
  EXPECT_EQ(FindTaker(StoreDuty::kDrained, "", stores), nullptr);
}

TEST(LeaseRulesTest, ADrainedStoreSpreadsWhatItHas) {
  std::vector<DirectoryStore> stores = {Alive("own"), Alive("a", 1), Alive("b", 0)};
  stores[0].is_own = true;
  const auto moves = PlanMoves("own", StoreDuty::kDrained,
                               {{"m1", ""}, {"m2", ""}, {"m3", "a"}, {"m4", ""}}, stores);
  ASSERT_EQ(moves.size(), 4u);
  EXPECT_EQ(moves.at("m1").name, "b");
  EXPECT_EQ(moves.at("m2").name, "a");
  EXPECT_EQ(moves.at("m3").name, "a");
  EXPECT_EQ(moves.at("m4").name, "b");
  const auto moved =
      PlanMoves("own", StoreDuty::kTakesMissions, {{"m1", "own"}, {"m2", ""}, {"m3", "b"}}, stores);
  ASSERT_EQ(moved.size(), 1u);
  EXPECT_EQ(moved.at("m3").name, "b");
  EXPECT_THAT(PlanMoves("own", StoreDuty::kDrained, {{"m1", ""}}, {stores[0]}), IsEmpty());
}

}  // namespace
}  // namespace corbslam::map_store

#include "map_store/fleet/balance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

DirectoryStore Store(const std::string& name, double busy, double processors = 4) {
  DirectoryStore store;
  store.name = name;
  store.lease_left = absl::Seconds(10);
  store.load = StoreLoad{busy * processors, processors, 0, 0, 0};
  return store;
}

std::string ChosenOf(const std::vector<HeldMission>& held, const DirectoryStore& giver,
                     const DirectoryStore& taker) {
  const HeldMission* chosen = ChooseMission(held, *giver.load, *taker.load, {});
  return chosen == nullptr ? "none" : chosen->name;
}

TEST(PairStoresTest, TheBusiestGivesToTheLeastBusyAndSoOn) {
  EXPECT_THAT(PairStores({Store("a", 0.8), Store("b", 0.1), Store("c", 0.95), Store("d", 0.3)}, {}),
              ElementsAre(BalancePair{"c", "b"}, BalancePair{"a", "d"}));
  EXPECT_THAT(PairStores({}, {}), IsEmpty());
  EXPECT_THAT(PairStores({Store("alone", 1)}, {}), IsEmpty());
}

TEST(PairStoresTest, NobodyGivesBelowTheThresholdOrWhereOthersAreAsBusy) {
  EXPECT_THAT(PairStores({Store("a", 0.69), Store("b", 0)}, {}), IsEmpty());
  EXPECT_THAT(PairStores({Store("a", 0.9), Store("b", 0.75)}, {}), IsEmpty());
  EXPECT_THAT(PairStores({Store("a", 0.9), Store("b", 0)}, {.above = 0}), IsEmpty());
}

TEST(PairStoresTest, MemoryCountsAsProcessorsDo) {
  DirectoryStore full = Store("full", 0.1);
  full.load->resident_bytes = 95;
  full.load->budget_bytes = 100;
  EXPECT_THAT(PairStores({full, Store("b", 0.2)}, {}), ElementsAre(BalancePair{"full", "b"}));
}

TEST(PairStoresTest, WhoIsGoneOrTakesNothingOrIsSilentOrRestsIsLeftOut) {
  const DirectoryStore busy = Store("busy", 1);
  DirectoryStore other = Store("other", 0);
  other.lease_left = absl::ZeroDuration();
  EXPECT_THAT(PairStores({busy, other}, {}), IsEmpty());
  other = Store("other", 0);
  other.is_cordoned = true;
  EXPECT_THAT(PairStores({busy, other}, {}), IsEmpty());
  other = Store("other", 0);
  other.load.reset();
  EXPECT_THAT(PairStores({busy, other}, {}), IsEmpty());
  other = Store("other", 0);
  other.since_balanced = absl::Seconds(59);
  EXPECT_THAT(PairStores({busy, other}, {}), IsEmpty());
  other.since_balanced = absl::Seconds(60);
  EXPECT_THAT(PairStores({busy, other}, {}), ElementsAre(BalancePair{"busy", "other"}));
  DirectoryStore resting = busy;
  resting.since_balanced = absl::Seconds(1);
  EXPECT_THAT(PairStores({resting, other}, {}), IsEmpty());
}

TEST(ChooseMissionTest, TheHeaviestGoesThatDoesNotMakeTheTakerTheBusierOne) {
  const std::vector<HeldMission> held = {
      {"light", {0.4, 0}}, {"right", {1.2, 0}}, {"heavy", {2.0, 0}}};
  EXPECT_EQ(ChosenOf(held, Store("a", 0.9), Store("b", 0.1)), "right");
  // On few processors it would weigh too much.
  EXPECT_EQ(ChosenOf(held, Store("a", 0.9), Store("b", 0.1, 1)), "light");
}

TEST(ChooseMissionTest, OneMissionThatIsAllThatAStoreHasStays) {
  EXPECT_EQ(ChosenOf({{"all", {3.6, 0}}}, Store("a", 0.9), Store("b", 0)), "none");
}

TEST(ChooseMissionTest, WhatHasJustComeStaysAndWhatHelpsNothingStays) {
  HeldMission mission{"m", {1, 0}, absl::Minutes(9)};
  EXPECT_EQ(ChosenOf({mission}, Store("a", 0.9), Store("b", 0)), "none");
  mission.since_moved = absl::Minutes(10);
  EXPECT_EQ(ChosenOf({mission}, Store("a", 0.9), Store("b", 0)), "m");
  mission.weight = {0, 50};
  EXPECT_EQ(ChosenOf({mission}, Store("a", 0.9), Store("b", 0)), "none");
  EXPECT_EQ(ChosenOf({}, Store("a", 0.9), Store("b", 0)), "none");
}

TEST(ChooseMissionTest, AMoveIsNeverTakenBackByTheRules) {
  // Whatever the loads, the taker is not to give the mission back.
  for (double giver = 0.75; giver <= 1; giver += 0.05) {
    for (double taker = 0; taker < giver - 0.2; taker += 0.05) {
      for (double weight = 0.05; weight < 4; weight += 0.05) {
        const HeldMission mission{"m", {weight, 0}};
        DirectoryStore a = Store("a", giver);
        DirectoryStore b = Store("b", taker);
        if (ChosenOf({mission}, a, b) == "none") continue;
        a.load->busy_processors -= weight;
        b.load->busy_processors += weight;
        EXPECT_LE(b.load->Pressure(), a.load->Pressure() + 1e-9);
        EXPECT_LE(b.load->Pressure(), BalanceRules().above + 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace corbslam::map_store

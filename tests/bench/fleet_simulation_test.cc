#include "tests/bench/fleet_simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_join.h"

namespace corbslam::tests {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

FleetOptions OfSeed(uint64_t seed) {
  FleetOptions options;
  options.seed = seed;
  options.stores_per_database = 2 + static_cast<int>(seed % 5);
  options.missions_per_database = 4 * options.stores_per_database;
  return options;
}

TEST(FleetSimulationTest, WhateverGoesWrongNothingIsThatMustNotBe) {
  uint64_t faults = 0;
  uint64_t lost = 0;
  uint64_t balanced = 0;
  uint64_t refused = 0;
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    const FleetResult result = SimulateFleet(OfSeed(seed));
    EXPECT_THAT(result.violations, IsEmpty());
    EXPECT_GT(result.acknowledged, 0u);
    faults += result.faults;
    lost += result.lost;
    balanced += result.balancing_moves;
    refused += result.refused_writes;
  }
  // It has tried what it is about.
  EXPECT_GT(faults, 3000u);
  EXPECT_GT(lost, 1000u);
  EXPECT_GT(balanced, 500u);
  EXPECT_GT(refused, 0u);
}

TEST(FleetSimulationTest, TheSameSeedIsTheSameFleet) {
  const FleetResult first = SimulateFleet(OfSeed(7));
  const FleetResult second = SimulateFleet(OfSeed(7));
  EXPECT_EQ(first.events, second.events);
  EXPECT_EQ(first.acknowledged, second.acknowledged);
  EXPECT_EQ(first.interruption_max_s, second.interruption_max_s);
}

// What the simulation is worth: it breaks where a rule is left out.
TEST(FleetSimulationTest, WithoutALookAtTheOwnLeaseRobotsAreToldOfOldAcknowledgements) {
  std::string found;
  for (uint64_t seed = 1; seed <= 100 && found.empty(); ++seed) {
    FleetOptions options = OfSeed(seed);
    options.checks_own_lease = false;
    found = absl::StrJoin(SimulateFleet(options).violations, "\n");
  }
  EXPECT_THAT(found, HasSubstr("batches and had"));
}

TEST(FleetSimulationTest, WithoutEpochsTwoWriteIntoOneMission) {
  std::string found;
  for (uint64_t seed = 1; seed <= 100 && found.empty(); ++seed) {
    FleetOptions options = OfSeed(seed);
    options.checks_epoch = false;
    found = absl::StrJoin(SimulateFleet(options).violations, "\n");
  }
  EXPECT_THAT(found, HasSubstr("writes into mission"));
}

TEST(FleetSimulationTest, AFleetWithoutFaultsServesAllAndSettles) {
  FleetOptions options = OfSeed(1);
  options.between_faults = absl::InfiniteDuration();
  const FleetResult result = SimulateFleet(options);
  EXPECT_THAT(result.violations, IsEmpty());
  EXPECT_EQ(result.lost, 0u);
  EXPECT_EQ(result.refused_writes, 0u);
  // A store gives one mission a minute at most.
  EXPECT_LE(result.balancing_moves, 7u * 3);
}

TEST(FleetSimulationTest, AllThatADisasterHitsIsServedAgain) {
  FleetOptions options;
  options.databases = 4;
  options.stores_per_database = 10;
  options.missions_per_database = 100;
  options.between_faults = absl::InfiniteDuration();
  options.between_batches = absl::Seconds(5);
  options.duration = absl::Minutes(3);
  for (const Disaster disaster : {Disaster::kLostRack, Disaster::kLostDatabase, Disaster::kHerd}) {
    options.disaster = disaster;
    const FleetResult result = SimulateFleet(options);
    EXPECT_THAT(result.violations, IsEmpty());
    EXPECT_GT(result.all_served_after_s, 0);
    EXPECT_LT(result.all_served_after_s, 150);
  }
}

}  // namespace
}  // namespace corbslam::tests

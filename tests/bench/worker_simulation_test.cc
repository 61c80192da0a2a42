#include "tests/bench/worker_simulation.h"

#include <gtest/gtest.h>

namespace corbslam::tests {
namespace {

TEST(WorkerSimulationTest, GreedyMissionsKeepNobodyWaiting) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    WorkersOptions options;
    options.seed = seed;
    options.between_faults = absl::InfiniteDuration();
    const WorkersResult result = SimulateWorkers(options);
    // Four missions ask again at once, 28 every few seconds, with adjustments of up to 20 s on six
    // threads: nobody waits for long, and those that ask seldom are answered about as they ask.
    EXPECT_LT(result.longest_overlap_s, 80) << seed;
    EXPECT_GT(result.fewest, 30u) << seed;
    EXPECT_GT(result.adjustments, 100u) << seed;
  }
}

TEST(WorkerSimulationTest, WhatDeadAndHungWorkersHadOthersDo) {
  uint64_t again = 0;
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    WorkersOptions options;
    options.seed = seed;
    const WorkersResult result = SimulateWorkers(options);
    again += result.asked_again;
    EXPECT_GT(result.fewest, 20u) << seed;
    // Of each mission one overlap and one adjustment at most.
    EXPECT_LE(result.waiting, 64u) << seed;
  }
  EXPECT_GT(again, 1000u);
}

TEST(WorkerSimulationTest, TheSameSeedIsTheSameWork) {
  EXPECT_EQ(SimulateWorkers({}).overlaps, SimulateWorkers({}).overlaps);
}

}  // namespace
}  // namespace corbslam::tests

// Simulates stores whose missions ask fusion workers for work, under a virtual clock, with workers
// that die or hang. Which worker is asked and whose request comes next is the code that ships
// (services/client/remote/worker_choice.h, services/server/work_turns.h).
#ifndef CORBSLAM_TESTS_BENCH_WORKER_SIMULATION_H_
#define CORBSLAM_TESTS_BENCH_WORKER_SIMULATION_H_

#include <cstdint>

#include "absl/time/time.h"

namespace corbslam::tests {

struct WorkersOptions {
  uint64_t seed = 1;
  int stores = 4;
  int missions_per_store = 8;
  int workers = 3;
  int threads = 2;        // Of a worker.
  int max_requests = 32;  // That a worker holds.
  absl::Duration duration = absl::Minutes(10);
  // A mission asks again so long after it was answered; the first mission of each store at once.
  absl::Duration between_requests = absl::Seconds(4);
  absl::Duration between_faults = absl::Minutes(1);  // Infinite: there are none.
};

struct WorkersResult {
  uint64_t overlaps = 0;     // That were answered.
  uint64_t adjustments = 0;  // Likewise.
  uint64_t asked_again = 0;  // Requests that a worker lost or did not take.
  uint64_t waiting = 0;      // At the end.
  // Seconds from a request to its answer, the longest: of missions that ask now and then, and of
  // those that ask at once. Without faults only.
  double longest_overlap_s = 0;
  double longest_adjustment_s = 0;
  // Overlaps of the mission that was answered least often, of those that ask now and then, and of
  // the one that was answered most often.
  uint64_t fewest = 0;
  uint64_t most = 0;
};

// The same options give the same result.
WorkersResult SimulateWorkers(const WorkersOptions& options);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_WORKER_SIMULATION_H_

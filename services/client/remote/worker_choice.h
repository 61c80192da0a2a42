// Which fusion worker is asked next.
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_WORKER_CHOICE_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_WORKER_CHOICE_H_

#include <cstddef>
#include <vector>

#include "absl/time/time.h"

namespace corbslam::services {

// A worker as who asks it knows it.
struct WorkerStanding {
  int running = 0;  // Requests under way.
  // When it last took no request: it was gone, or full.
  absl::Time refused_at = absl::InfinitePast();
  bool is_tried = false;  // For this request.
};

// So long after it took no request, a worker is asked after all others.
inline constexpr absl::Duration kRefusedWorkerRests = absl::Seconds(10);

// Returns the index of the worker with the fewest requests under way, of those that were not tried
// for the request; of equals the first from `first` on, which is who asks' own one where the list
// is the same for all who ask. Returns the number of workers if there is none.
inline size_t ChooseWorker(const std::vector<WorkerStanding>& workers, size_t first,
                           absl::Time now) {
  const auto rests = [now](const WorkerStanding& worker) {
    return now - worker.refused_at < kRefusedWorkerRests;
  };
  size_t best = workers.size();
  for (size_t i = 0; i < workers.size(); ++i) {
    const size_t at = (first + i) % workers.size();
    const WorkerStanding& worker = workers[at];
    if (worker.is_tried) continue;
    const bool is_better = best == workers.size() || (rests(worker) != rests(workers[best])
                                                          ? rests(workers[best])
                                                          : worker.running < workers[best].running);
    if (is_better) best = at;
  }
  return best;
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_WORKER_CHOICE_H_

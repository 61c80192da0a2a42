// Runs what the missions' fusion lanes have to do on a FusionWorker: on threads of its own, or
// synchronously.
#ifndef CORBSLAM_MAP_STORE_PROCESS_FUSION_EXECUTOR_H_
#define CORBSLAM_MAP_STORE_PROCESS_FUSION_EXECUTOR_H_

#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "map_store/process/mission.h"
#include "map_store/process/work_signal.h"
#include "map_store/process/worker_watch.h"
#include "map_store/state/lookups.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::map_store {

// Runs the lanes of all missions. Thread-safe.
class FusionExecutor {
 public:
  // Lists missions for one round, which does not keep them in memory.
  using ListMissions = std::function<std::vector<std::weak_ptr<Mission>>()>;

  // `worker` (not owned, may be null) must outlive it. `when_done` is called, on any thread, when
  // something was done: what was copied for it is freed.
  FusionExecutor(FusionWorker* worker, absl::Duration retry_after,
                 std::function<absl::Time()> clock, std::function<void()> when_done)
      : worker_(worker),
        retry_after_(retry_after),
        when_done_(std::move(when_done)),
        watch_(std::move(clock)) {}
  ~FusionExecutor() { Stop(); }

  // Starts `threads_per_lane` threads for each lane; none without a worker.
  void Start(ListMissions missions, int threads_per_lane);
  // Cancels the jobs that run and joins the threads. The missions must still be there.
  void Stop();
  // Tells the threads that there may be something to do.
  void Wake() { signal_.Wake(); }

  // Does all that the mission has to do, here and now, in the order of the policy.
  void RunUntilIdle(Mission& mission);

  // Null: there is none.
  FusionWorker* worker() const { return worker_; }
  bool has_worker() const { return worker_ != nullptr; }
  // Returns the outage that lasts; nullopt while workers take requests, and before the first one.
  std::optional<WorkerOutage> worker_outage() const { return watch_.outage(); }

 private:
  enum class Turn { kNothingToDo, kDone, kTryLater, kRefused };

  static Turn TurnOf(JobEnd end);
  Turn RunOne(Mission& mission, FusionLane lane);
  void RunLane(FusionLane lane);

  FusionWorker* const worker_;
  const absl::Duration retry_after_;
  const std::function<void()> when_done_;
  WorkerWatch watch_;
  ListMissions missions_;
  WorkSignal signal_;
  std::vector<std::thread> threads_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_FUSION_EXECUTOR_H_

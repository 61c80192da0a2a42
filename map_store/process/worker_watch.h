// Knows whether fusion workers take what the store asks of them.
#ifndef CORBSLAM_MAP_STORE_PROCESS_WORKER_WATCH_H_
#define CORBSLAM_MAP_STORE_PROCESS_WORKER_WATCH_H_

#include <functional>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/state/lookups.h"
#include "slam/util/rare_reminder.h"

namespace corbslam::map_store {

// Watches for outages. An outage begins with the first request that is UNAVAILABLE and ends with
// the first one that is not. Its beginning is logged with the cause, again more and more seldom,
// and so is its end. Thread-safe.
class WorkerWatch {
 public:
  explicit WorkerWatch(std::function<absl::Time()> clock) : clock_(std::move(clock)) {}

  // Notes how a request ended. One that was cancelled says nothing of workers.
  void Note(const absl::Status& status);
  // Returns the outage that lasts; nullopt: there is none.
  std::optional<WorkerOutage> outage() const;

 private:
  const std::function<absl::Time()> clock_;
  mutable absl::Mutex mutex_;
  std::optional<WorkerOutage> outage_ ABSL_GUARDED_BY(mutex_);
  RareReminder reminder_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_WORKER_WATCH_H_

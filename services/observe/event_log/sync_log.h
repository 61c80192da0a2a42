// Writes the agents' sessions to the log.
#ifndef CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_SYNC_LOG_H_
#define CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_SYNC_LOG_H_

#include <map>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/map_store_service/streams/sync_observer.h"
#include "slam/util/rare_reminder.h"

namespace corbslam::services {

// Says when a session begins and how it ends, and why a session or a batch was refused. A robot
// that asks again and again for a session is mentioned only rarely. Thread-safe.
class SyncLog : public SyncObserver {
 public:
  void OnOpened(const SessionAgent& agent) override;
  void OnRefused(const SessionAgent& agent, const absl::Status& status) override;
  void OnClosed(const SessionAgent& agent, const absl::Status& status) override;
  void OnApplied(const SessionAgent& agent, const MapUpdateBatch& batch, absl::Duration took,
                 const absl::Status& status) override;

 private:
  bool IsWorthALine(const SessionAgent& agent);

  absl::Mutex mutex_;
  // Agents that were refused since their last session.
  std::map<SessionAgent, RareReminder> refused_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_SYNC_LOG_H_

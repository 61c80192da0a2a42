// The agents' sessions in the log.
#ifndef CORBSLAM_SERVICES_LOGGING_SYNC_LOG_H_
#define CORBSLAM_SERVICES_LOGGING_SYNC_LOG_H_

#include "services/map_store_service/sync_observer.h"

namespace corbslam {

// Says when a session begins and how it ends, and why a batch was refused. Thread-safe.
class SyncLog : public SyncObserver {
 public:
  void OnOpened(const SessionAgent& agent) override;
  void OnClosed(const SessionAgent& agent, const absl::Status& status) override;
  void OnApplied(const SessionAgent& agent, const MapUpdateBatch& batch, absl::Duration took,
                 const absl::Status& status) override;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_LOGGING_SYNC_LOG_H_

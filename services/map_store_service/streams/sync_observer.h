// Hears what happens on the agents' streams, for those who only watch.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_SYNC_OBSERVER_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_SYNC_OBSERVER_H_

#include <cstddef>
#include <string>
#include <tuple>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "slam/exchange/map_update.h"

namespace corbslam::services {

// Says whose session it is.
struct SessionAgent {
  std::string mission;
  std::string agent;
  // Who opened it, and from where, for people to read. Sessions of one agent are of one agent
  // whoever opens them: it does not count in comparisons.
  std::string caller = {};

  friend bool operator==(const SessionAgent& a, const SessionAgent& b) {
    return std::tie(a.mission, a.agent) == std::tie(b.mission, b.agent);
  }
  friend auto operator<=>(const SessionAgent& a, const SessionAgent& b) {
    return std::tie(a.mission, a.agent) <=> std::tie(b.mission, b.agent);
  }
};

// Hears of sessions. It is called on the service's threads, for several sessions at once but for
// each session one call after the other, and must return soon.
class SyncObserver {
 public:
  virtual ~SyncObserver() = default;
  virtual void OnOpened(const SessionAgent&) {}
  // The store lets no session begin.
  virtual void OnRefused(const SessionAgent&, const absl::Status&) {}
  // Called once for each OnOpened.
  virtual void OnClosed(const SessionAgent&, const absl::Status&) {}
  // Called for each message of an open session, with its bytes.
  virtual void OnReceived(const SessionAgent&, size_t) {}
  virtual void OnSent(const SessionAgent&, size_t) {}
  // The batch is there as a whole, and is applied next.
  virtual void OnBatch(const SessionAgent&, const MapUpdateBatch&) {}
  // The batch is durable and will be acknowledged, unless `status` refuses it. The duration is
  // since its last part was read.
  virtual void OnApplied(const SessionAgent&, const MapUpdateBatch&, absl::Duration,
                         const absl::Status&) {}
  // A shared update of so many bytes has waited for so long for the budget of the agent's link.
  virtual void OnShareDelayed(const SessionAgent&, size_t, absl::Duration) {}
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_SYNC_OBSERVER_H_

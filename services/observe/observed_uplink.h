// Makes an uplink that tells others of its sessions and batches.
#ifndef CORBSLAM_SERVICES_OBSERVE_OBSERVED_UPLINK_H_
#define CORBSLAM_SERVICES_OBSERVE_OBSERVED_UPLINK_H_

#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

// Hears of an uplink, on the threads of the agent and of the uplink, several at once; its functions
// must return soon. Sessions and acknowledgements are heard here before the agent hears them.
class UplinkObserver {
 public:
  virtual ~UplinkObserver() = default;
  virtual void OnOpening() {}
  virtual void OnOpened() {}
  // Called when the transport has taken the batch, which it was offered at that time; again when
  // the batch is sent again after a break. The batch may be acknowledged before this call.
  virtual void OnSent(const MapUpdateBatch&, absl::Time) {}
  virtual void OnAcknowledged(const Acknowledgement&) {}
  virtual void OnClosed(const absl::Status&) {}
};

// Makes an uplink whose thread contract and effect are those of `uplink`. Neither it nor
// `observers` is owned; both must outlive the result.
std::unique_ptr<Uplink> MakeObservedUplink(Uplink* uplink, std::vector<UplinkObserver*> observers);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_OBSERVED_UPLINK_H_

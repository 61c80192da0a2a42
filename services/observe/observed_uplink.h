// An uplink that tells others what goes up and what comes down.
#ifndef CORBSLAM_SERVICES_OBSERVE_OBSERVED_UPLINK_H_
#define CORBSLAM_SERVICES_OBSERVE_OBSERVED_UPLINK_H_

#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "slam/exchange/uplink.h"

namespace corbslam {

// Called on the threads of the agent and of the uplink, several at once; must return soon. What
// comes down is heard here before the agent hears it.
class UplinkObserver {
 public:
  virtual ~UplinkObserver() = default;
  virtual void OnOpening() {}
  virtual void OnOpened() {}
  // The transport has taken the batch, which it was offered at that time; again after a break. It
  // may be acknowledged before this is called.
  virtual void OnSent(const MapUpdateBatch&, absl::Time) {}
  virtual void OnAcknowledged(const Acknowledgement&) {}
  virtual void OnShared(const SharedUpdate&) {}
  virtual void OnClosed(const absl::Status&) {}
};

// Thread contract and effect are those of `uplink`. Neither it nor `observers` is owned; both must
// outlive this.
std::unique_ptr<Uplink> MakeObservedUplink(Uplink* uplink, std::vector<UplinkObserver*> observers);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_OBSERVE_OBSERVED_UPLINK_H_

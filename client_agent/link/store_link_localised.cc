// Implements the part of StoreLink that says where a robot was that only localises.
#include <glog/logging.h>

#include <utility>

#include "client_agent/link/store_link.h"

namespace corbslam::client_agent {

void StoreLink::AddLocalised(const LocalisedFrame& frame) {
  if (uplink_ != nullptr && options_.localise_only) localised_.AddPlace(frame);
}

void StoreLink::SendLocalised(bool all) {
  {
    absl::MutexLock lock(&mutex_);
    if (session_ != Session::kOpen) return;
  }
  const absl::Duration interval = all ? absl::ZeroDuration() : options_.flush_interval;
  localised_.SendTo(*uplink_, budget_, interval, options_.clock());
}

void StoreLink::BeginLocalised(const Capabilities& store) {
  if (!store.keeps_localised && !std::exchange(told_not_kept_, true)) {
    LOG(WARNING) << "the map store is of an older version, which keeps no trajectory of a robot "
                    "that only localises: it can't be asked for it later";
  }
  localised_.BeginSession(store.keeps_localised);
}

void StoreLink::OnLocalisedKept(const LocalisedKept& kept) {
  localised_.NoteKept(kept);
  absl::MutexLock lock(&mutex_);
  backoff_.Reset();
  refused_backoff_.Reset();
  wake_ = true;
}

}  // namespace corbslam::client_agent

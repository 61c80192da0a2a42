// Holds where frames of a robot that changes nothing were, until they are sent.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_LOCALISED_OUTBOX_H_
#define CORBSLAM_CLIENT_AGENT_LINK_LOCALISED_OUTBOX_H_

#include <cstddef>
#include <deque>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

// Of what was never sent the newest frames stay. Thread-safe.
class LocalisedOutbox {
 public:
  static constexpr size_t kMaxFrames = 5000;

  void Add(const LocalisedFrame& frame) {
    absl::MutexLock lock(&mutex_);
    frames_.push_back(frame);
    if (frames_.size() > kMaxFrames) frames_.pop_front();
  }

  // Sends all frames, if the last were sent that long ago.
  void SendTo(Uplink& uplink, absl::Duration interval, absl::Time now) {
    absl::MutexLock lock(&mutex_);
    if (frames_.empty() || now - last_ < interval) return;
    if (!uplink.SendLocalised({frames_.begin(), frames_.end()})) return;
    last_ = now;
    frames_.clear();
  }

 private:
  absl::Mutex mutex_;
  std::deque<LocalisedFrame> frames_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_LOCALISED_OUTBOX_H_

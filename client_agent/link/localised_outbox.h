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

  // Sends all frames, if the last were sent that long ago. Called by one thread; others may add
  // meanwhile.
  void SendTo(Uplink& uplink, absl::Duration interval, absl::Time now) {
    std::vector<LocalisedFrame> frames;
    {
      absl::MutexLock lock(&mutex_);
      if (frames_.empty() || now - last_ < interval) return;
      frames.assign(frames_.begin(), frames_.end());
      frames_.clear();
    }
    const bool is_sent = uplink.SendLocalised(frames);
    absl::MutexLock lock(&mutex_);
    if (is_sent) {
      last_ = now;
      return;
    }
    frames_.insert(frames_.begin(), frames.begin(), frames.end());
    while (frames_.size() > kMaxFrames) frames_.pop_front();
  }

 private:
  absl::Mutex mutex_;
  std::deque<LocalisedFrame> frames_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_LOCALISED_OUTBOX_H_

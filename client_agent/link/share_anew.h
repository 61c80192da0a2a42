// Holds what the map store tells anew, until it can take the place of what was told before.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_SHARE_ANEW_H_
#define CORBSLAM_CLIENT_AGENT_LINK_SHARE_ANEW_H_

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "client_agent/shared/shared_content.h"

namespace corbslam::client_agent {

// A robot that asks for all anew lets go of what is not near it any more. It tracks in what it had
// until as much is here as it needs. Not thread-safe.
class ShareAnew {
 public:
  // So many keyframes are enough, and none is waited for longer than this after the first word.
  static constexpr size_t kEnough = 24;
  static constexpr absl::Duration kMaxWait = absl::Seconds(3);

  // `held`: the keyframes of others that the robot has.
  void Begin(size_t held) {
    *this = ShareAnew();
    is_waiting_ = true;
    enough_ = std::min(held, kEnough);
  }
  bool is_waiting() const { return is_waiting_; }

  // Takes the next update. Returns what is to be taken over now, all at once: nothing yet, or all
  // that was held, the first of which takes out what was told before.
  std::vector<ArrivedUpdate> Add(ArrivedUpdate arrived, absl::Time now) {
    if (waiting_.empty()) {
      arrived.update.restart = true;
      first_ = now;
    }
    keyframes_ += arrived.update.keyframes.size();
    waiting_.push_back(std::move(arrived));
    return keyframes_ >= enough_ ? Take() : TakeDue(now);
  }
  // Returns what has been waited for long enough.
  std::vector<ArrivedUpdate> TakeDue(absl::Time now) {
    if (waiting_.empty() || now - first_ < kMaxWait) return {};
    return Take();
  }

 private:
  std::vector<ArrivedUpdate> Take() {
    is_waiting_ = false;
    return std::exchange(waiting_, {});
  }

  bool is_waiting_ = false;
  size_t enough_ = 0;
  size_t keyframes_ = 0;
  absl::Time first_;
  std::vector<ArrivedUpdate> waiting_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_SHARE_ANEW_H_

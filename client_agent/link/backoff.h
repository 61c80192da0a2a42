// Says how long to wait until what failed is tried again.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_BACKOFF_H_
#define CORBSLAM_CLIENT_AGENT_LINK_BACKOFF_H_

#include <algorithm>
#include <cstdint>
#include <random>

#include "absl/time/time.h"

namespace corbslam::client_agent {

// Not thread-safe.
class Backoff {
 public:
  // `seed` is of the jitter, which keeps robots from coming all at once.
  Backoff(absl::Duration least, absl::Duration most, uint64_t seed)
      : least_(least), most_(most), random_(seed) {}

  // Returns how long to wait after one attempt more: between half of and all of what is twice as
  // long each time, up to the most.
  absl::Duration Next() {
    const double growth = static_cast<double>(uint64_t{1} << std::min(attempts_++, 10));
    std::uniform_real_distribution<double> jitter(0.5, 1.0);
    return std::min(least_ * growth, most_) * jitter(random_);
  }
  // Something has worked: the next wait is as short as the first.
  void Reset() { attempts_ = 0; }

 private:
  const absl::Duration least_;
  const absl::Duration most_;
  int attempts_ = 0;
  std::mt19937_64 random_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_BACKOFF_H_

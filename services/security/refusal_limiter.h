// Limits how many refusals are written down for one caller.
#ifndef CORBSLAM_SERVICES_SECURITY_REFUSAL_LIMITER_H_
#define CORBSLAM_SERVICES_SECURITY_REFUSAL_LIMITER_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/time/time.h"

namespace corbslam::services {

// Counts refusals of each peer, a minute at a time. Not thread-safe.
class RefusalLimiter {
 public:
  explicit RefusalLimiter(size_t per_minute) : per_minute_(per_minute) {}

  // What was left out of a peer's minute.
  struct LeftOut {
    std::string peer;
    absl::Time since;
    uint64_t count = 0;
  };

  // Returns true if a refusal of this peer is to be written. Peers beyond kMaxPeers of a minute
  // count as one.
  bool Admit(const std::string& peer, absl::Time now) {
    const bool is_known = minutes_.contains(peer) || minutes_.size() < kMaxPeers;
    Minute& minute = minutes_.try_emplace(is_known ? peer : "others", Minute{now}).first->second;
    if (minute.written < per_minute_) {
      ++minute.written;
      return true;
    }
    ++minute.left_out;
    return false;
  }

  // Takes what was left out in minutes that are over.
  std::vector<LeftOut> TakeOver(absl::Time now) {
    std::vector<LeftOut> over;
    for (auto entry = minutes_.begin(); entry != minutes_.end();) {
      const auto& [peer, minute] = *entry;
      const bool is_over = now - minute.begin >= absl::Minutes(1) || now < minute.begin;
      if (is_over && minute.left_out > 0) over.push_back({peer, minute.begin, minute.left_out});
      entry = is_over ? minutes_.erase(entry) : std::next(entry);
    }
    return over;
  }

 private:
  static constexpr size_t kMaxPeers = 200;

  struct Minute {
    absl::Time begin;
    size_t written = 0;
    uint64_t left_out = 0;
  };

  const size_t per_minute_;
  std::map<std::string, Minute> minutes_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_REFUSAL_LIMITER_H_

// Lets those wait who are refused often.
#ifndef CORBSLAM_SERVICES_VIEWER_REFUSAL_PACE_H_
#define CORBSLAM_SERVICES_VIEWER_REFUSAL_PACE_H_

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Counts refusals of each host. Thread-safe.
class RefusalPace {
 public:
  // Notes a refusal; returns how long its answer is to be held back. The first kAtOnce of a host
  // come at once, and one more each second.
  absl::Duration Note(const std::string& host, absl::Time now) {
    absl::MutexLock lock(&mutex_);
    if (hosts_.size() >= kMaxHosts && !hosts_.contains(host)) Forget(now);
    const bool is_known = hosts_.contains(host) || hosts_.size() < kMaxHosts;
    const auto found = hosts_.try_emplace(is_known ? host : "others", absl::InfinitePast()).first;
    absl::Time& used_until = found->second;
    used_until = std::min(std::max(used_until, now - kAtOnce * kPause) + kPause, now + kMemory);
    return used_until <= now ? absl::ZeroDuration() : kPause;
  }

 private:
  static constexpr size_t kMaxHosts = 1000;
  static constexpr int kAtOnce = 10;
  static constexpr absl::Duration kPause = absl::Seconds(1);
  static constexpr absl::Duration kMemory = absl::Minutes(1);

  void Forget(absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    std::erase_if(hosts_, [now](const auto& entry) { return entry.second < now - kMemory; });
  }

  absl::Mutex mutex_;
  // Until when a host has used up what it may.
  std::map<std::string, absl::Time> hosts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_REFUSAL_PACE_H_

// Counts how a server's calls ended.
#ifndef CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_CALL_TALLY_H_
#define CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_CALL_TALLY_H_

#include <cstdint>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/match.h"
#include "absl/synchronization/mutex.h"
#include "services/server/rpc_observer.h"

namespace corbslam::services {

struct CallCounts {
  uint64_t done = 0;
  uint64_t failed = 0;
  uint64_t cancelled = 0;

  friend bool operator==(const CallCounts&, const CallCounts&) = default;
};

// Counts the calls of one service, such as "corbslam.v1.FusionWorker", and lets another observer
// hear of all (null: nobody does; not owned). Thread-safe.
class CallTally : public RpcObserver {
 public:
  CallTally(std::string service, RpcObserver* next)
      : prefix_(std::move(service) + "/"), next_(next) {}

  void OnStarted(absl::string_view method) override {
    if (next_ != nullptr) next_->OnStarted(method);
  }
  void OnReceived(absl::string_view method, size_t bytes) override {
    if (next_ != nullptr) next_->OnReceived(method, bytes);
  }
  void OnSent(absl::string_view method, size_t bytes) override {
    if (next_ != nullptr) next_->OnSent(method, bytes);
  }
  void OnFinished(absl::string_view method, grpc::StatusCode code, absl::Duration took) override {
    if (next_ != nullptr) next_->OnFinished(method, code, took);
    if (!absl::StartsWith(method, prefix_)) return;
    absl::MutexLock lock(&mutex_);
    if (code == grpc::StatusCode::OK) {
      ++counts_.done;
    } else if (code == grpc::StatusCode::CANCELLED) {
      ++counts_.cancelled;
    } else {
      ++counts_.failed;
    }
  }

  // Returns the counts since the last call.
  CallCounts Take() {
    absl::MutexLock lock(&mutex_);
    return std::exchange(counts_, CallCounts());
  }

 private:
  const std::string prefix_;
  RpcObserver* const next_;
  absl::Mutex mutex_;
  CallCounts counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_CALL_TALLY_H_

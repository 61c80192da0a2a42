// Sends batches one after the other, each when the one before was acknowledged.
#ifndef CORBSLAM_TESTS_FAULT_AWAITING_SENDER_H_
#define CORBSLAM_TESTS_FAULT_AWAITING_SENDER_H_

#include <grpcpp/channel.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "slam/exchange/uplink.h"

namespace corbslam::tests {

// For one thread; its calls block. Numbers the batches of each local map from 1.
class AwaitingSender : private UplinkListener {
 public:
  AwaitingSender(const std::shared_ptr<grpc::Channel>& channel, std::string mission,
                 std::string agent);
  ~AwaitingSender() override;

  // Opens a session where none stands, and sends the batch under the next number of its local map.
  // OK: it is acknowledged. Else the status says why the store ended the session, and the number is
  // free again; it is DEADLINE_EXCEEDED after `patience`.
  absl::Status Send(MapUpdateBatch batch, absl::Duration patience);

 private:
  void OnSessionOpened(const SessionGrant& grant) override;
  void OnAcknowledged(const Acknowledgement& acknowledgement) override;
  void OnShared(SharedUpdate) override {}
  void OnExactPlacesWanted() override {}
  void OnSessionClosed(const absl::Status& reason) override;

  absl::Status WaitForSession(absl::Time deadline);
  bool HasEnded() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return end_.has_value(); }
  bool HasSessionOrEnd() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return open_ || HasEnded(); }
  bool IsAnswered() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return HasEnded() || acknowledged_ >= awaited_;
  }

  const std::string mission_;
  const std::string agent_;
  // Holds the last acknowledged number of each local map.
  std::map<LocalMapId, uint64_t> numbers_;
  mutable absl::Mutex mutex_;
  bool open_ ABSL_GUARDED_BY(mutex_) = false;
  // Why there is no session any more; none while one stands or opens.
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_) = absl::CancelledError("not opened");
  // What is known of the batch that is under way, and its local map.
  LocalMapId local_map_ ABSL_GUARDED_BY(mutex_);
  uint64_t awaited_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t acknowledged_ ABSL_GUARDED_BY(mutex_) = 0;

  const std::unique_ptr<Uplink> uplink_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_AWAITING_SENDER_H_

// Notes what an uplink says.
#ifndef CORBSLAM_SERVICES_TESTING_UPLINK_NOTES_H_
#define CORBSLAM_SERVICES_TESTING_UPLINK_NOTES_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

// Notes what an uplink tells its listener. Thread-safe. Each wait takes 20 s at most.
class UplinkNotes : public UplinkListener {
 public:
  void OnSessionOpened(const SessionGrant& grant) override {
    absl::MutexLock lock(&mutex_);
    grant_ = grant;
  }
  void OnAcknowledged(const Acknowledgement& acknowledgement) override {
    absl::MutexLock lock(&mutex_);
    acknowledged_.push_back(acknowledgement);
  }
  void OnShared(SharedUpdate) override {}
  void OnExactPlacesWanted() override {
    absl::MutexLock lock(&mutex_);
    ++exact_places_wanted_;
  }
  void OnSessionClosed(const absl::Status& reason) override {
    absl::MutexLock lock(&mutex_);
    closed_ = reason;
  }

  // Returns nullopt if the session was closed before, or nothing came.
  std::optional<SessionGrant> WaitForGrant() {
    absl::MutexLock lock(&mutex_);
    const auto come = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return grant_.has_value() || closed_.has_value();
    };
    mutex_.AwaitWithTimeout(absl::Condition(&come), kPatience);
    return grant_;
  }
  // Returns the number of the last acknowledged batch, once `count` acknowledgements have come;
  // else 0.
  uint64_t WaitForAcknowledgements(size_t count) {
    absl::MutexLock lock(&mutex_);
    const auto come = [this, count]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return acknowledged_.size() >= count;
    };
    return mutex_.AwaitWithTimeout(absl::Condition(&come), kPatience) ? acknowledged_.back().number
                                                                      : 0;
  }
  // Returns false if nobody asked.
  bool WaitUntilExactPlacesAreWanted() {
    absl::MutexLock lock(&mutex_);
    const auto come = [this]()
                          ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return exact_places_wanted_ > 0; };
    return mutex_.AwaitWithTimeout(absl::Condition(&come), kPatience);
  }
  // Returns why the session was closed; DEADLINE_EXCEEDED if it wasn't.
  absl::Status WaitForClose() {
    absl::MutexLock lock(&mutex_);
    const auto come = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return closed_.has_value(); };
    mutex_.AwaitWithTimeout(absl::Condition(&come), kPatience);
    return closed_.value_or(absl::DeadlineExceededError("the session is not closed"));
  }
  bool IsClosed() {
    absl::MutexLock lock(&mutex_);
    return closed_.has_value();
  }

 private:
  static constexpr absl::Duration kPatience = absl::Seconds(20);

  absl::Mutex mutex_;
  std::optional<SessionGrant> grant_ ABSL_GUARDED_BY(mutex_);
  std::vector<Acknowledgement> acknowledged_ ABSL_GUARDED_BY(mutex_);
  int exact_places_wanted_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<absl::Status> closed_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TESTING_UPLINK_NOTES_H_

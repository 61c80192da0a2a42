// Streams what a caller watches: first what there is, then what comes, until the caller goes.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_WATCH_REACTOR_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_WATCH_REACTOR_H_

#include <grpcpp/support/server_callback.h>

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "services/convert/status.h"
#include "services/map_store_service/streams/stream_limits.h"
#include "services/server/stream_task.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

enum class WatchJob { kNone, kWrite, kFinish, kPoll };

// Looks whenever something has changed and what was found before is written, so that a slow reader
// costs no more memory than one look finds. Derived classes say where to look. Owns itself once it
// is started.
template <typename Response>
class WatchReactor : public grpc::ServerWriteReactor<Response>, private StreamTask<WatchJob> {
 public:
  // `ticket` is an error if there were too many streams before this one.
  WatchReactor(TaskPool& pool, absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> ticket)
      : StreamTask(pool, Threads::kLookUps), ticket_(std::move(ticket)) {}

  // Begins. The reactor may be gone when this returns.
  void Start() {
    ListenForClose();
    if (!ticket_.ok()) {
      NeverWork();
      this->Finish(ToGrpcStatus(ticket_.status()));
      return;
    }
    OnChange();
  }

  void OnWriteDone(bool ok) override {
    Note([this, ok]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      writing_ = false;
      messages_.pop_front();
      cancelled_ |= !ok;
    });
  }
  void OnCancel() override {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { cancelled_ = true; });
  }
  void OnDone() override {
    link_.Cut();
    delete this;
  }

 protected:
  // One poll finds this.
  struct Found {
    std::vector<Response> messages;
    bool more = false;  // There is more already: poll again once these are written.
  };

  // These are called by one thread at a time, without locks. Subscribe comes first, until it is OK;
  // an error ends the stream. `listener` may be called from any thread, at any time.
  virtual absl::Status Subscribe(std::function<void()> listener) = 0;
  virtual absl::StatusOr<Found> Poll() = 0;
  // Called last, after a Subscribe that was OK.
  virtual void Unsubscribe() = 0;

 private:
  void ListenForClose() {
    if (!ticket_.ok()) return;
    const absl::Status open = (*ticket_)->SetCloseListener(
        link_.Guard([this](const absl::Status& why) { OnClose(why); }));
    if (!open.ok()) ticket_ = open;
  }

  WatchJob NextJob() const override ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    if (writing_) return WatchJob::kNone;
    if (cancelled_ || end_) return WatchJob::kFinish;
    if (!messages_.empty()) return WatchJob::kWrite;
    return changed_ ? WatchJob::kPoll : WatchJob::kNone;
  }

  void BeginJob(WatchJob job) override ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (job == WatchJob::kWrite) writing_ = true;
    if (job == WatchJob::kPoll) changed_ = false;
  }

  void DoJob(WatchJob job) override {
    if (job == WatchJob::kWrite) WriteNext();
    if (job == WatchJob::kPoll) {
      absl::Status status = PollAndKeep();
      if (!status.ok()) status = PollAgain(status);
      absl::MutexLock lock(&mutex_);
      if (!status.ok()) end_ = status;
    }
    // The reactor may be gone once this returns.
    if (job == WatchJob::kFinish) End();
  }

  void WriteNext() {
    const Response* message = nullptr;
    {
      absl::MutexLock lock(&mutex_);
      message = &messages_.front();
    }
    this->StartWrite(message);
  }

  absl::Status PollAndKeep() {
    if (!subscribed_) RETURN_IF_ERROR(Subscribe(link_.Guard([this] { OnChange(); })));
    subscribed_ = true;
    ASSIGN_OR_RETURN(Found found, Poll());
    absl::MutexLock lock(&mutex_);
    held_.reset();
    changed_ = changed_ || found.more;
    for (Response& message : found.messages) messages_.push_back(std::move(message));
    return absl::OkStatus();
  }

  // Polls again once what was not there is; returns the error if it never will be.
  absl::Status PollAgain(const absl::Status& error) {
    return pool().Defer(error, link_.Guard([this](const auto& ready) {
      Note([this, &ready]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        changed_ = ready.ok();
        if (!ready.ok()) end_ = ready.status();
        if (ready.ok()) held_ = *ready;
      });
    }));
  }

  void OnClose(const absl::Status& why) {
    Note([this, &why]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { end_ = why; });
  }

  void OnChange() {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { changed_ = true; });
  }

  void End() {
    if (subscribed_) Unsubscribe();
    absl::Status status;
    {
      absl::MutexLock lock(&mutex_);
      status = end_.value_or(absl::CancelledError("the caller went away"));
    }
    // The ticket is given back before the caller hears of the end: it may come again at once.
    ticket_->reset();
    this->Finish(ToGrpcStatus(status));
  }

  absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> ticket_;
  bool subscribed_ = false;  // Only DoJob uses it.

  bool changed_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
  std::deque<Response> messages_ ABSL_GUARDED_BY(mutex_);
  // The next poll needs this in memory.
  std::shared_ptr<const void> held_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_WATCH_REACTOR_H_

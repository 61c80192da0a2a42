#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/convert/status.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/streams/read_timer.h"
#include "services/server/stream_task.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

enum class LocalizeJob { kNone, kAnswer, kFinish };

// Answers one request, then reads the next. Owns itself.
class LocalizeReactor : public grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>,
                        private StreamTask<LocalizeJob> {
 public:
  using Answer = std::function<absl::Status(
      const v1::LocalizeRequest&, const std::function<bool()>& goes_on, v1::LocalizeResponse*)>;

  LocalizeReactor(TaskPool& pool, StreamLimits& limits, absl::string_view peer, Answer answer)
      : StreamTask(pool, Threads::kLookUps),
        ticket_(limits.Enter(peer)),
        answer_(std::move(answer)) {
    if (!ticket_.ok()) {
      NeverWork();
      Finish(ToGrpcStatus(ticket_.status()));
      return;
    }
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    Note([this, ok]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      if (ok) {
        has_request_ = true;
      } else if (!end_) {
        end_ = absl::OkStatus();
      }
    });
  }
  void OnWriteDone(bool ok) override {
    if (ok) return StartRead(&request_);
    End(absl::CancelledError("the caller went away"));
  }
  void OnCancel() override {
    cancelled_ = true;
    End(absl::CancelledError("the caller went away"));
  }
  void OnDone() override {
    link_.Cut();
    delete this;
  }

 private:
  void End(const absl::Status& status) {
    Note([this, &status]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      if (!end_) end_ = status;
    });
  }

  LocalizeJob NextJob() const override ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    if (end_) return LocalizeJob::kFinish;
    return has_request_ && !waits_ ? LocalizeJob::kAnswer : LocalizeJob::kNone;
  }

  void DoJob(LocalizeJob job) override {
    if (job == LocalizeJob::kAnswer) return AnswerOne();
    absl::Status end;
    {
      absl::MutexLock lock(&mutex_);
      end = *end_;
    }
    if (ticket_.ok()) ticket_->reset();
    // The reactor may be gone once this is called.
    Finish(ToGrpcStatus(end));
  }

  void AnswerOne() {
    response_.Clear();
    absl::Status status = answer_(
        request_, [this] { return !cancelled_; }, &response_);
    if (!status.ok()) {
      status = AnswerLater(status);
      if (status.ok()) return;
    }
    {
      absl::MutexLock lock(&mutex_);
      has_request_ = waits_ = false;
      held_.reset();
      if (!status.ok() && !end_) end_ = status;
      if (end_) return;
    }
    StartWrite(&response_);
  }

  // Answers again once what was not there is; returns the error if it never will be.
  absl::Status AnswerLater(const absl::Status& error) {
    {
      absl::MutexLock lock(&mutex_);
      waits_ = true;
    }
    return pool().Defer(error, link_.Guard([this](const auto& ready) {
      Note([this, &ready]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        waits_ = false;
        if (ready.ok()) held_ = *ready;
        if (!ready.ok() && !end_) end_ = ready.status();
      });
    }));
  }

  absl::StatusOr<std::shared_ptr<const void>> ticket_;
  const Answer answer_;
  std::atomic<bool> cancelled_ = false;
  // Only gRPC uses it between StartRead and OnReadDone, and only DoJob otherwise.
  v1::LocalizeRequest request_;
  v1::LocalizeResponse response_;

  bool has_request_ ABSL_GUARDED_BY(mutex_) = false;
  // True: the request waits for its mission, which is held once it is awake.
  bool waits_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<const void> held_ ABSL_GUARDED_BY(mutex_);
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>* MapStoreService::LocalizeStream(
    grpc::CallbackServerContext* context, MayAsk may_look) {
  const auto answer = [this, may_look = std::move(may_look)](
                          const v1::LocalizeRequest& request, const std::function<bool()>& goes_on,
                          v1::LocalizeResponse* response) -> absl::Status {
    RETURN_IF_ERROR(may_look(request));
    return AnswerLocalize(request, goes_on, response);
  };
  return new LocalizeReactor(locating_pool_, limits_, context->peer(), answer);
}

}  // namespace corbslam::services

// Handles one request to a fusion worker: receives it, works, and sends progress and the result.
#ifndef CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_WORK_REACTOR_H_
#define CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_WORK_REACTOR_H_

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "services/convert/status.h"
#include "services/convert/work/work.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/fusion_worker_service/work_queue.h"
#include "services/server/task_pool.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

// Reads on gRPC's threads, works on the pool. At most one progress message waits to be written.
// Owns itself.
template <typename RequestReader, typename Result, typename RequestMessage,
          typename ResponseMessage>
class WorkReactor : public grpc::ServerBidiReactor<RequestMessage, ResponseMessage> {
 public:
  using Request = typename decltype(std::declval<RequestReader>().Finish())::value_type;
  using Compute = std::function<absl::StatusOr<Result>(const Request&, const ProgressCallback&)>;

  // `requests` counts the requests under way. All references must outlive it.
  WorkReactor(TaskPool& pool, WorkQueue& queue, WorkOwner owner, std::atomic<int>& requests,
              const FusionWorkerServiceOptions& options, Compute compute)
      : pool_(pool),
        turns_(queue),
        owner_(std::move(owner)),
        requests_(requests),
        options_(options),
        compute_(std::move(compute)) {
    if (++requests_ <= options_.max_requests) {
      this->StartRead(&message_);
    } else {
      End(absl::UnavailableError(
          absl::StrCat("this worker has ", options_.max_requests, " requests already")));
    }
  }

  void OnReadDone(bool ok) override {
    if (!ok) return End(absl::InvalidArgumentError("the request ended before its end came"));
    const absl::Status status = reader_->Add(message_);
    if (!status.ok()) return End(status);
    if (!reader_->ended()) return this->StartRead(&message_);
    {
      absl::MutexLock lock(&mutex_);
      waiting_ = true;
    }
    turns_.Schedule(pool_, owner_, [this] { Work(); });
  }

  void OnWriteDone(bool ok) override {
    if (!ok) cancelled_ = true;
    Advance([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      writing_ = false;
      queue_.pop_front();
    });
  }

  void OnCancel() override {
    cancelled_ = true;
    {
      absl::MutexLock lock(&mutex_);
      if (!waiting_) return;
      // The request may wait for a thread for long: another request could have its place, and its
      // memory.
      reader_.reset();
    }
    LeavePlace();
  }

  void OnDone() override {
    const FusionWorkerServiceOptions& options = options_;
    delete this;
    if (options.when_done != nullptr) options.when_done();
  }

 private:
  void Work() {
    {
      absl::MutexLock lock(&mutex_);
      waiting_ = false;
    }
    const absl::Status status = TryWork();
    End(cancelled_ ? absl::CancelledError("the caller went away") : status);
  }

  absl::Status TryWork() {
    if (cancelled_) return absl::OkStatus();
    absl::StatusOr<Result> result = [&]() -> absl::StatusOr<Result> {
      ASSIGN_OR_RETURN(const Request request, reader_->Finish());
      return compute_(request, [this](double fraction) { return ReportProgress(fraction); });
    }();
    RETURN_IF_ERROR(result.status());
    WriteWork<ResponseMessage>(
        *result, std::function<bool(ResponseMessage)>(
                     [this](ResponseMessage message) { return Send(std::move(message)); }));
    return absl::OkStatus();
  }

  bool ReportProgress(double fraction) {
    if (cancelled_) return false;
    {
      absl::MutexLock lock(&mutex_);
      if (!queue_.empty()) return true;
    }
    ResponseMessage message;
    message.mutable_progress()->set_fraction(fraction);
    return Send(std::move(message));
  }

  bool Send(ResponseMessage message) {
    if (cancelled_) return false;
    Advance([this, &message]()
                ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { queue_.push_back(std::move(message)); });
    return true;
  }

  void End(const absl::Status& status) {
    Advance([this, &status]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      if (!end_) end_ = status;
    });
  }

  // Makes a change, then writes what waits; finishes when nothing waits and the end is known. Both
  // happen under one lock: once the end is known, the end of a write finishes too, and then the
  // reactor is gone.
  template <typename Change>
  void Advance(Change change) {
    const ResponseMessage* next = nullptr;
    std::optional<absl::Status> end;
    {
      absl::MutexLock lock(&mutex_);
      change();
      if (writing_ || finished_) return;
      if (!queue_.empty() && !cancelled_) {
        next = &queue_.front();
        writing_ = true;
      } else if (end_) {
        end = end_;
        finished_ = true;
      }
    }
    if (next != nullptr) return this->StartWrite(next);
    if (!end) return;
    // The place is free before the caller knows of the end: its next request must find room.
    LeavePlace();
    // The reactor may be gone once this is called.
    this->Finish(ToGrpcStatus(*end));
  }

  void LeavePlace() {
    {
      absl::MutexLock lock(&mutex_);
      if (!has_place_) return;
      has_place_ = false;
    }
    --requests_;
  }

  TaskPool& pool_;
  WorkQueue& turns_;
  const WorkOwner owner_;
  std::atomic<int>& requests_;
  const FusionWorkerServiceOptions& options_;
  const Compute compute_;
  std::atomic<bool> cancelled_{false};
  RequestMessage message_;
  // gRPC's callbacks use it while they read, then Work does; nullopt once the request has been
  // cancelled while it waited.
  std::optional<WorkReader<RequestReader, v1::MapChunk>> reader_{std::in_place};

  absl::Mutex mutex_;
  std::deque<ResponseMessage> queue_ ABSL_GUARDED_BY(mutex_);
  // True: it is counted among the requests under way.
  bool has_place_ ABSL_GUARDED_BY(mutex_) = true;
  // True: all of the request has come, and no thread has begun with it.
  bool waiting_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_WORK_REACTOR_H_

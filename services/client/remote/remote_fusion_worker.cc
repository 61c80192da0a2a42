#include "services/client/remote/remote_fusion_worker.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/function_ref.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "corbslam/v1/fusion_worker_service.grpc.pb.h"
#include "services/client/remote/worker_choice.h"
#include "services/convert/features.h"
#include "services/convert/geometry.h"
#include "services/convert/status.h"
#include "services/convert/work/work.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kAskAgain = absl::Milliseconds(100);

absl::Status Cancelled() { return absl::CancelledError("the caller cancelled"); }

// Asks again and again, until it is destroyed, whether a call is still wanted, and cancels the call
// when it is not: also while the request is sent, and while it waits for its turn in the worker.
// Thread-safe.
class CallWatch {
 public:
  // `context` and `progress` must outlive the watch.
  CallWatch(grpc::ClientContext& context, const ProgressCallback& progress)
      : context_(context), progress_(progress) {
    if (progress_ != nullptr) thread_ = StartThread("call watch", [this] { Run(); });
  }
  ~CallWatch() {
    {
      absl::MutexLock lock(&mutex_);
      ended_ = true;
    }
    if (thread_.joinable()) thread_.join();
  }

  void Report(double fraction) {
    absl::MutexLock lock(&mutex_);
    fraction_ = fraction;
    Ask();
  }
  bool cancelled() const {
    absl::MutexLock lock(&mutex_);
    return cancelled_;
  }

 private:
  void Run() {
    absl::MutexLock lock(&mutex_);
    while (!mutex_.AwaitWithTimeout(absl::Condition(&ended_), kAskAgain)) Ask();
  }
  void Ask() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (cancelled_ || progress_ == nullptr || progress_(fraction_)) return;
    cancelled_ = true;
    context_.TryCancel();
  }

  grpc::ClientContext& context_;
  const ProgressCallback& progress_;
  mutable absl::Mutex mutex_;
  double fraction_ ABSL_GUARDED_BY(mutex_) = 0;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

// Returns true if the worker did not look at the request: another worker, or this one once it is
// set up right, may take it.
bool IsNotTaken(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsUnimplemented(status) ||
         absl::IsUnauthenticated(status) || absl::IsPermissionDenied(status);
}

// Reads progress and the result of a call.
template <typename Result, typename Stream, typename Response>
absl::StatusOr<Result> ReadResult(Stream& stream, grpc::ClientContext& context, CallWatch& watch) {
  WorkReader<ResultReader<Response>, v1::ResultChunk> reader;
  absl::Status failure;
  Response response;
  while (failure.ok() && stream.Read(&response)) {
    if (response.has_progress()) {
      watch.Report(response.progress().fraction());
    } else {
      failure = reader.Add(response);
    }
  }
  if (!failure.ok()) context.TryCancel();
  const absl::Status status = FromGrpcStatus(stream.Finish());
  if (watch.cancelled()) return Cancelled();
  if (!failure.ok()) return failure;
  // Nobody here cancelled the call: the worker is being stopped.
  if (absl::IsCancelled(status)) return absl::UnavailableError(status.message());
  RETURN_IF_ERROR(status);
  if (!reader.ended()) return absl::UnavailableError("the worker ended before its result did");
  return reader.Finish();
}

class RemoteWorkers : public RemoteFusionWorkers {
 public:
  RemoteWorkers(std::vector<RemoteWorker> workers, absl::Duration deadline) : deadline_(deadline) {
    Use(std::move(workers));
  }

  void Use(std::vector<RemoteWorker> workers) override {
    std::vector<std::shared_ptr<Worker>> used;
    absl::MutexLock lock(&mutex_);
    for (RemoteWorker& worker : workers) {
      const auto known = std::find_if(workers_.begin(), workers_.end(), [&worker](const auto& one) {
        return one != nullptr && !worker.address.empty() && one->address == worker.address;
      });
      if (known != workers_.end()) {
        used.push_back(std::move(*known));
        *known = nullptr;
        continue;
      }
      used.push_back(std::make_shared<Worker>());
      used.back()->address = std::move(worker.address);
      used.back()->stub = v1::FusionWorker::NewStub(worker.channel);
      used.back()->explain = std::move(worker.explain);
    }
    workers_ = std::move(used);
  }

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    return Run<VerifyOverlapResult, v1::VerifyOverlapRequest, v1::VerifyOverlapResponse>(
        request, progress, &v1::FusionWorker::Stub::VerifyOverlap);
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override {
    return Run<FuseMapsResult, v1::FuseMapsRequest, v1::FuseMapsResponse>(
        request, progress, &v1::FusionWorker::Stub::FuseMaps);
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override {
    return Run<AdjustBundleResult, v1::AdjustBundleRequest, v1::AdjustBundleResponse>(
        request, progress, &v1::FusionWorker::Stub::AdjustBundle);
  }
  absl::StatusOr<LocateFrameResult> LocateFrame(const LocateFrameRequest& request,
                                                const ProgressCallback& progress) override {
    return Run<LocateFrameResult, v1::LocateFrameRequest, v1::LocateFrameResponse>(
        request, progress, &v1::FusionWorker::Stub::LocateFrame);
  }
  absl::StatusOr<ExtractFeaturesResult> ExtractFeatures(
      const ExtractFeaturesRequest& request) override {
    return AskInTurn<ExtractFeaturesResult>(
        nullptr, [&](v1::FusionWorker::Stub& stub) { return ExtractOn(stub, request); });
  }

 private:
  struct Worker {
    std::string address;
    std::unique_ptr<v1::FusionWorker::Stub> stub;
    std::function<absl::Status(const absl::Status& seen)> explain;
    // `mutex_` protects it.
    WorkerStanding standing;
  };
  using WorkerPtr = std::shared_ptr<Worker>;

  template <typename Result, typename RequestMessage, typename ResponseMessage, typename Request,
            typename Method>
  absl::StatusOr<Result> Run(const Request& request, const ProgressCallback& progress,
                             Method method) {
    return AskInTurn<Result>(progress, [&](v1::FusionWorker::Stub& stub) {
      return RunOn<Result, RequestMessage, ResponseMessage>(stub, request, progress, method);
    });
  }

  // Asks the workers one after the other, the least busy first, until one answers.
  template <typename Result>
  absl::StatusOr<Result> AskInTurn(
      const ProgressCallback& progress,
      absl::FunctionRef<absl::StatusOr<Result>(v1::FusionWorker::Stub&)> ask) {
    absl::Status last = absl::UnavailableError("there are no workers");
    std::vector<WorkerPtr> tried;
    while (true) {
      if (progress != nullptr && !progress(0)) return Cancelled();
      const WorkerPtr worker = Acquire(tried);
      if (worker == nullptr) break;
      tried.push_back(worker);
      absl::StatusOr<Result> result = ask(*worker->stub);
      Release(*worker, IsNotTaken(result.status()));
      if (!IsNotTaken(result.status())) return result;
      last = result.status();
    }
    return tried.empty() ? last : Explain(*tried.back(), last);
  }

  // Returns UNAVAILABLE, whatever the error was.
  static absl::Status Explain(const Worker& worker, const absl::Status& seen) {
    const absl::Status explained = worker.explain == nullptr ? seen : worker.explain(seen);
    const bool has_words = absl::IsUnavailable(explained);
    return absl::UnavailableError(has_words ? std::string(explained.message())
                                            : explained.ToString());
  }

  template <typename Result, typename RequestMessage, typename ResponseMessage, typename Request,
            typename Method>
  absl::StatusOr<Result> RunOn(v1::FusionWorker::Stub& stub, const Request& request,
                               const ProgressCallback& progress, Method method) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + absl::ToChronoMilliseconds(deadline_));
    if (!request.mission.empty()) context.AddMetadata(kMissionHeader, request.mission);
    const auto stream = (stub.*method)(&context);
    CallWatch watch(context, progress);
    // A worker that refuses the request early ends the stream: then writing fails, and reading
    // tells why.
    WriteWork<RequestMessage>(request,
                              std::function<bool(RequestMessage)>(
                                  [&](RequestMessage message) { return stream->Write(message); }));
    stream->WritesDone();
    return ReadResult<Result, std::remove_reference_t<decltype(*stream)>, ResponseMessage>(
        *stream, context, watch);
  }

  absl::StatusOr<ExtractFeaturesResult> ExtractOn(v1::FusionWorker::Stub& stub,
                                                  const ExtractFeaturesRequest& request) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + absl::ToChronoMilliseconds(deadline_));
    v1::ExtractFeaturesRequest message;
    ToProto(request, message.mutable_picture());
    message.set_features(static_cast<uint32_t>(std::max(request.features, 0)));
    v1::ExtractFeaturesResponse response;
    RETURN_IF_ERROR(FromGrpcStatus(stub.ExtractFeatures(&context, message, &response)));
    ExtractFeaturesResult result;
    ASSIGN_OR_RETURN(result.camera, FromProto(response.camera()));
    ASSIGN_OR_RETURN(result.features, FromProto(response.features(), result.camera));
    return result;
  }

  // Returns null if all were tried.
  WorkerPtr Acquire(const std::vector<WorkerPtr>& tried) {
    absl::MutexLock lock(&mutex_);
    std::vector<WorkerStanding> standings;
    for (const WorkerPtr& worker : workers_) {
      standings.push_back(worker->standing);
      standings.back().is_tried = std::find(tried.begin(), tried.end(), worker) != tried.end();
    }
    const size_t chosen = ChooseWorker(standings, /*first=*/0, absl::Now());
    if (chosen == workers_.size()) return nullptr;
    ++workers_[chosen]->standing.running;
    return workers_[chosen];
  }
  void Release(Worker& worker, bool was_refused) {
    absl::MutexLock lock(&mutex_);
    --worker.standing.running;
    if (was_refused) worker.standing.refused_at = absl::Now();
  }

  const absl::Duration deadline_;
  absl::Mutex mutex_;
  std::vector<WorkerPtr> workers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<RemoteFusionWorkers> MakeRemoteFusionWorkers(std::vector<RemoteWorker> workers,
                                                             absl::Duration deadline) {
  return std::make_unique<RemoteWorkers>(std::move(workers), deadline);
}

std::unique_ptr<FusionWorker> MakeRemoteFusionWorker(
    std::vector<std::shared_ptr<grpc::Channel>> channels,
    const RemoteFusionWorkerOptions& options) {
  std::vector<RemoteWorker> workers;
  for (size_t i = 0; i < channels.size(); ++i) {
    workers.push_back({"", std::move(channels[i])});
    if (options.explain == nullptr) continue;
    workers.back().explain = [explain = options.explain, i](const absl::Status& seen) {
      return explain(i, seen);
    };
  }
  return MakeRemoteFusionWorkers(std::move(workers), options.deadline);
}

}  // namespace corbslam::services

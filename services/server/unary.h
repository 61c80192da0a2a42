// Adapts plain functions to gRPC's reactors.
#ifndef CORBSLAM_SERVICES_SERVER_UNARY_H_
#define CORBSLAM_SERVICES_SERVER_UNARY_H_

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/convert/status.h"
#include "services/server/task_pool.h"

namespace corbslam::services {

// Answers one call on this thread, or later on the pool if the pool's deferrer says so.
inline void AnswerOrDefer(TaskPool& pool, grpc::ServerUnaryReactor* reactor,
                          grpc::CallbackServerContext* context,
                          const std::function<absl::Status()>& answer) {
  if (context->IsCancelled()) return reactor->Finish(grpc::Status::CANCELLED);
  const absl::Status status = answer();
  if (status.ok()) return reactor->Finish(grpc::Status::OK);
  const auto again = [&pool, reactor, context, answer](const auto& ready) {
    if (!ready.ok()) return reactor->Finish(ToGrpcStatus(ready.status()));
    pool.ScheduleLookUp([&pool, reactor, context, answer, held = *ready] {
      AnswerOrDefer(pool, reactor, context, answer);
    });
  };
  const absl::Status refused = pool.Defer(status, again);
  if (!refused.ok()) reactor->Finish(ToGrpcStatus(refused));
}

// Answers one call with what `answer` returns, computed on the pool, or with RESOURCE_EXHAUSTED
// where too many wait. The request and the response live until then. An `answer` that could not be
// given yet (TaskPool::SetDeferrer) is asked for again: it must not have done anything.
inline grpc::ServerUnaryReactor* AnswerOn(TaskPool& pool, grpc::CallbackServerContext* context,
                                          std::function<absl::Status()> answer) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const absl::Status waits =
      pool.ScheduleCall([&pool, reactor, context, answer = std::move(answer)] {
        AnswerOrDefer(pool, reactor, context, answer);
      });
  if (!waits.ok()) reactor->Finish(ToGrpcStatus(waits));
  return reactor;
}

// Streams messages to a caller, one at a time, as fast as it reads.
template <typename Response>
class StreamReactor : public grpc::ServerWriteReactor<Response> {
 public:
  // Fills the next message; returns false after the last one.
  using Next = std::function<bool(Response&)>;
  // Computes what is to be streamed; an error ends the call, or puts it off, as AnswerOn's.
  using Prepare = std::function<absl::StatusOr<Next>()>;

  // Prepares on the pool, then streams; RESOURCE_EXHAUSTED where too many calls wait. Keeps
  // `ticket` until the stream has ended; where it is an error, the stream ends with that. Messages
  // behind the first one are made on `rest`, on `pool` where that is null. Owns itself.
  static StreamReactor* Start(TaskPool& pool, absl::StatusOr<std::shared_ptr<const void>> ticket,
                              Prepare prepare, TaskPool* rest = nullptr) {
    auto* reactor = new StreamReactor(rest != nullptr ? *rest : pool);
    absl::Status started = ticket.status();
    if (started.ok()) {
      reactor->ticket_ = *std::move(ticket);
      started = pool.ScheduleCall(
          [reactor, &pool, prepare = std::move(prepare)] { reactor->Begin(pool, prepare); });
    }
    if (!started.ok()) reactor->End(ToGrpcStatus(started));
    return reactor;
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return End(grpc::Status::CANCELLED);
    // To make a message may take long, and gRPC has few threads.
    rest_.ScheduleLookUp([this] { WriteNext(); });
  }
  void OnCancel() override { cancelled_ = true; }
  void OnDone() override { delete this; }

 private:
  explicit StreamReactor(TaskPool& rest) : rest_(rest) {}

  void Begin(TaskPool& pool, const Prepare& prepare) {
    if (cancelled_) return End(grpc::Status::CANCELLED);
    absl::StatusOr<Next> next = prepare();
    if (!next.ok()) return Defer(pool, prepare, next.status());
    next_ = *std::move(next);
    WriteNext();
  }

  void Defer(TaskPool& pool, const Prepare& prepare, const absl::Status& status) {
    const auto again = [this, &pool, prepare](const auto& ready) {
      if (!ready.ok()) return End(ToGrpcStatus(ready.status()));
      pool.ScheduleLookUp([this, &pool, prepare, held = *ready] { Begin(pool, prepare); });
    };
    const absl::Status refused = pool.Defer(status, again);
    if (!refused.ok()) End(ToGrpcStatus(refused));
  }

  void WriteNext() {
    if (cancelled_) return End(grpc::Status::CANCELLED);
    response_.Clear();
    if (!next_(response_)) return End(grpc::Status::OK);
    this->StartWrite(&response_);
  }

  void End(const grpc::Status& status) {
    // The ticket is given back before the caller hears of the end: it may come again at once.
    ticket_.reset();
    // The reactor may be gone once this is called.
    this->Finish(status);
  }

  TaskPool& rest_;
  std::atomic<bool> cancelled_{false};
  std::shared_ptr<const void> ticket_;
  Next next_;
  Response response_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_UNARY_H_

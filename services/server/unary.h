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

// Answers one call with what `answer` returns, computed on the pool, or with RESOURCE_EXHAUSTED
// where too many wait. The request and the response live until then.
inline grpc::ServerUnaryReactor* AnswerOn(TaskPool& pool, grpc::CallbackServerContext* context,
                                          std::function<absl::Status()> answer) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const absl::Status waits = pool.ScheduleCall([reactor, context, answer = std::move(answer)] {
    const bool is_wanted = !context->IsCancelled();
    reactor->Finish(is_wanted ? ToGrpcStatus(answer()) : grpc::Status::CANCELLED);
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
  // Computes what is to be streamed; an error ends the call.
  using Prepare = std::function<absl::StatusOr<Next>()>;

  // Prepares on the pool, then streams; RESOURCE_EXHAUSTED where too many calls wait. Keeps
  // `ticket` until the stream has ended; where it is an error, the stream ends with that. Owns
  // itself.
  static StreamReactor* Start(TaskPool& pool, absl::StatusOr<std::shared_ptr<const void>> ticket,
                              Prepare prepare) {
    auto* reactor = new StreamReactor();
    absl::Status started = ticket.status();
    if (started.ok()) {
      reactor->ticket_ = *std::move(ticket);
      started =
          pool.ScheduleCall([reactor, prepare = std::move(prepare)] { reactor->Begin(prepare); });
    }
    if (!started.ok()) reactor->End(ToGrpcStatus(started));
    return reactor;
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return End(grpc::Status::CANCELLED);
    WriteNext();
  }
  void OnCancel() override { cancelled_ = true; }
  void OnDone() override { delete this; }

 private:
  void Begin(const Prepare& prepare) {
    if (cancelled_) return End(grpc::Status::CANCELLED);
    absl::StatusOr<Next> next = prepare();
    if (!next.ok()) return End(ToGrpcStatus(next.status()));
    next_ = *std::move(next);
    WriteNext();
  }

  void WriteNext() {
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

  std::atomic<bool> cancelled_{false};
  std::shared_ptr<const void> ticket_;
  Next next_;
  Response response_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_UNARY_H_

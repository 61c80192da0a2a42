// Adapters from plain functions to gRPC's reactors.
#ifndef CORBSLAM_SERVICES_SERVER_UNARY_H_
#define CORBSLAM_SERVICES_SERVER_UNARY_H_

#include <grpcpp/support/server_callback.h>

#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "services/convert/status.h"
#include "services/server/task_pool.h"

namespace corbslam {

// Answers one call with what `answer` returns, computed on the pool. The request and the response
// live until then.
inline grpc::ServerUnaryReactor* AnswerOn(TaskPool& pool, grpc::CallbackServerContext* context,
                                          std::function<absl::Status()> answer) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  pool.Schedule([reactor, answer = std::move(answer)] { reactor->Finish(ToGrpcStatus(answer())); });
  return reactor;
}

// Streams messages to a caller, one at a time, as fast as it reads.
template <typename Response>
class StreamReactor : public grpc::ServerWriteReactor<Response> {
 public:
  // Fills the next message; false after the last.
  using Next = std::function<bool(Response&)>;
  // Computes what is to be streamed; an error ends the call.
  using Prepare = std::function<absl::StatusOr<Next>()>;

  // Prepares on the pool, then streams. Owns itself.
  static StreamReactor* Start(TaskPool& pool, Prepare prepare) {
    auto* reactor = new StreamReactor();
    pool.Schedule([reactor, prepare = std::move(prepare)] {
      absl::StatusOr<Next> next = prepare();
      if (!next.ok()) return reactor->Finish(ToGrpcStatus(next.status()));
      reactor->next_ = *std::move(next);
      reactor->WriteNext();
    });
    return reactor;
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return this->Finish(grpc::Status::CANCELLED);
    WriteNext();
  }
  void OnDone() override { delete this; }

 private:
  void WriteNext() {
    response_.Clear();
    if (!next_(response_)) return this->Finish(grpc::Status::OK);
    this->StartWrite(&response_);
  }

  Next next_;
  Response response_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SERVER_UNARY_H_

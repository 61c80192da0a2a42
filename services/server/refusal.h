// Ends a call with an error before anything was done for it.
#ifndef CORBSLAM_SERVICES_SERVER_REFUSAL_H_
#define CORBSLAM_SERVICES_SERVER_REFUSAL_H_

#include <grpcpp/support/server_callback.h>

#include "absl/status/status.h"
#include "services/convert/status.h"

namespace corbslam::services {

inline grpc::ServerUnaryReactor* RefuseCall(grpc::CallbackServerContext* context,
                                            const absl::Status& status) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(ToGrpcStatus(status));
  return reactor;
}

// A stream that ends at once. Owns itself.
template <typename Response>
class RefusedStream : public grpc::ServerWriteReactor<Response> {
 public:
  explicit RefusedStream(const absl::Status& status) { this->Finish(ToGrpcStatus(status)); }
  void OnDone() override { delete this; }
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_REFUSAL_H_

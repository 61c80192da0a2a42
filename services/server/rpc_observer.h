// Hears of every call of a server: how many, how long, how large, how they ended.
#ifndef CORBSLAM_SERVICES_SERVER_RPC_OBSERVER_H_
#define CORBSLAM_SERVICES_SERVER_RPC_OBSERVER_H_

#include <grpcpp/support/server_interceptor.h>
#include <grpcpp/support/status.h>

#include <cstddef>
#include <memory>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Is called from gRPC's threads and from those that finish calls, several at once, and must return
// soon. `method` is one that the server has, as "package.Service/Method".
class RpcObserver {
 public:
  virtual ~RpcObserver() = default;
  virtual void OnStarted(absl::string_view method) = 0;
  // Called for each message, with its bytes without the 5 that gRPC puts before it; not for the
  // services that gRPC itself brings (health, reflection, channelz).
  virtual void OnReceived(absl::string_view method, size_t bytes) = 0;
  virtual void OnSent(absl::string_view method, size_t bytes) = 0;
  // Called once for each OnStarted; CANCELLED where the call ended without a status of ours.
  virtual void OnFinished(absl::string_view method, grpc::StatusCode code, absl::Duration took) = 0;
};

// Returns interceptors for grpc::ServerBuilder::experimental().SetInterceptorCreators. `observer`
// is not owned and must outlive the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeRpcInterceptors(
    RpcObserver* observer);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_RPC_OBSERVER_H_

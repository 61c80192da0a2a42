// Hears how calls of a server ended, with who called and about what.
#ifndef CORBSLAM_SERVICES_SERVER_CALL_AUDITOR_H_
#define CORBSLAM_SERVICES_SERVER_CALL_AUDITOR_H_

#include <grpcpp/support/server_interceptor.h>
#include <grpcpp/support/status.h>

#include <memory>
#include <string>

#include "absl/strings/string_view.h"

namespace corbslam::services {

// A call that has ended.
struct EndedCall {
  absl::string_view method;  // "package.Service/Method"
  const grpc::ServerContextBase* context = nullptr;
  std::string resource;  // What CallAuditor::OnAsked returned; empty before.
  grpc::Status status;
};

// Is called from gRPC's threads and from those that finish calls, several at once, and must return
// soon.
class CallAuditor {
 public:
  virtual ~CallAuditor() = default;
  // Returns what a request is about. `message` is what the method's handler is given: a protobuf
  // message, or a grpc::ByteBuffer for Sync. Called for our own services only, with a call's first
  // message.
  virtual std::string OnAsked(absl::string_view method, const grpc::ServerContextBase& context,
                              const void* message) = 0;
  // Called once for each call that ends with a status of ours: not where a connection breaks.
  virtual void OnEnded(const EndedCall& call) = 0;
  // The server did by itself what callers do otherwise, such as deleting a mission.
  virtual void OnOwnDoing(absl::string_view event, absl::string_view resource,
                          absl::string_view why) {
    (void)event, (void)resource, (void)why;
  }
};

// Returns interceptors for grpc::ServerBuilder::experimental().SetInterceptorCreators, which own
// the auditor together with others.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeAuditInterceptors(
    std::shared_ptr<CallAuditor> auditor);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_CALL_AUDITOR_H_

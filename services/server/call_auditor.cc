#include "services/server/call_auditor.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/strip.h"

namespace corbslam::services {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;
using grpc::experimental::ServerRpcInfo;

// Watches one call.
class AuditInterceptor : public grpc::experimental::Interceptor {
 public:
  AuditInterceptor(std::shared_ptr<CallAuditor> auditor, ServerRpcInfo* info)
      : auditor_(std::move(auditor)), info_(*info) {
    call_.method = absl::StripPrefix(info->method(), "/");
    // Requests of gRPC's own services are no messages of ours.
    asked_ = !absl::StartsWith(call_.method, "corbslam.");
  }

  void Intercept(InterceptorBatchMethods* methods) override {
    if (!asked_ && methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE)) {
      // The message is null at the end of a stream.
      if (const void* message = methods->GetRecvMessage()) {
        asked_ = true;
        call_.resource = auditor_->OnAsked(call_.method, *info_.server_context(), message);
      }
    }
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      call_.status = methods->GetSendStatus();
      End();
    }
    methods->Proceed();
  }

 private:
  void End() {
    if (ended_) return;
    ended_ = true;
    call_.context = info_.server_context();
    auditor_->OnEnded(call_);
  }

  const std::shared_ptr<CallAuditor> auditor_;
  ServerRpcInfo& info_;
  EndedCall call_;
  bool asked_ = false;
  bool ended_ = false;
};

class AuditInterceptors : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit AuditInterceptors(std::shared_ptr<CallAuditor> auditor) : auditor_(std::move(auditor)) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(ServerRpcInfo* info) override {
    return new AuditInterceptor(auditor_, info);
  }

 private:
  const std::shared_ptr<CallAuditor> auditor_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeAuditInterceptors(
    std::shared_ptr<CallAuditor> auditor) {
  return std::make_unique<AuditInterceptors>(std::move(auditor));
}

}  // namespace corbslam::services

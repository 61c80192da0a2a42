#include "services/server/connection_calls.h"

#include "absl/strings/match.h"

namespace corbslam::services {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;
using grpc::experimental::ServerRpcInfo;

class ConnectionInterceptor : public grpc::experimental::Interceptor {
 public:
  ConnectionInterceptor(ConnectionFront* front, ServerRpcInfo* info)
      : front_(*front), info_(*info) {}
  ~ConnectionInterceptor() override {
    if (connection_ != 0) front_.EndCall(connection_);
  }

  void Intercept(InterceptorBatchMethods* methods) override {
    // Who calls is known from here on.
    if (!begun_ &&
        methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_INITIAL_METADATA)) {
      begun_ = true;
      connection_ = front_.BeginCall(info_.server_context()->peer());
    }
    methods->Proceed();
  }

 private:
  ConnectionFront& front_;
  ServerRpcInfo& info_;
  bool begun_ = false;
  ConnectionFront::Id connection_ = 0;
};

class ConnectionInterceptors : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit ConnectionInterceptors(ConnectionFront* front) : front_(front) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(ServerRpcInfo* info) override {
    if (!absl::StartsWith(info->method(), "/corbslam.")) return nullptr;
    return new ConnectionInterceptor(front_, info);
  }

 private:
  ConnectionFront* const front_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeConnectionInterceptors(
    ConnectionFront* front) {
  return std::make_unique<ConnectionInterceptors>(front);
}

}  // namespace corbslam::services

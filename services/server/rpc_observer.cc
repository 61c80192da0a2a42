#include "services/server/rpc_observer.h"

#include <google/protobuf/message_lite.h>
#include <grpcpp/support/byte_buffer.h>

#include "absl/strings/match.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"

namespace corbslam::services {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;

// Says which type a message has: an interceptor is given messages without it.
enum class MessageType { kProtobuf, kBytes, kUnknown };

MessageType TypeOf(absl::string_view method) {
  if (!absl::StartsWith(method, "corbslam.")) return MessageType::kUnknown;
  // Sync is the one method that is served raw (services/map_store_service/map_store_service.h).
  return method == "corbslam.v1.MapStore/Sync" ? MessageType::kBytes : MessageType::kProtobuf;
}

// Observes one call.
class RpcInterceptor : public grpc::experimental::Interceptor {
 public:
  RpcInterceptor(RpcObserver* observer, absl::string_view method)
      : observer_(*observer), method_(method), type_(TypeOf(method)), start_(absl::Now()) {
    observer_.OnStarted(method_);
  }
  ~RpcInterceptor() override { Finish(grpc::StatusCode::CANCELLED); }

  void Intercept(InterceptorBatchMethods* methods) override {
    if (type_ != MessageType::kUnknown) ObserveMessages(*methods);
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      Finish(methods->GetSendStatus().error_code());
    }
    methods->Proceed();
  }

 private:
  void ObserveMessages(InterceptorBatchMethods& methods) {
    if (methods.QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE)) {
      // The message is null at the end of a stream.
      if (const void* message = methods.GetRecvMessage()) {
        observer_.OnReceived(method_, BytesOf(message));
      }
    }
    if (methods.QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_MESSAGE)) {
      // This serialises the message now instead of a moment later.
      if (const grpc::ByteBuffer* message = methods.GetSerializedSendMessage()) {
        observer_.OnSent(method_, message->Length());
      }
    }
  }

  size_t BytesOf(const void* message) const {
    if (type_ == MessageType::kBytes) {
      return static_cast<const grpc::ByteBuffer*>(message)->Length();
    }
    // All messages of generated classes have this base.
    return static_cast<const google::protobuf::MessageLite*>(message)->ByteSizeLong();
  }

  void Finish(grpc::StatusCode code) {
    if (finished_) return;
    finished_ = true;
    observer_.OnFinished(method_, code, absl::Now() - start_);
  }

  RpcObserver& observer_;
  // Owned by the server, which outlives its calls.
  const absl::string_view method_;
  const MessageType type_;
  const absl::Time start_;
  bool finished_ = false;
};

class RpcInterceptors : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit RpcInterceptors(RpcObserver* observer) : observer_(observer) {}

  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    return new RpcInterceptor(observer_, absl::StripPrefix(info->method(), "/"));
  }

 private:
  RpcObserver* const observer_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeRpcInterceptors(
    RpcObserver* observer) {
  return std::make_unique<RpcInterceptors>(observer);
}

}  // namespace corbslam::services

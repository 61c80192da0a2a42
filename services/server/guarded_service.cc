#include "services/server/guarded_service.h"

#include <glog/logging.h>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

using grpc::internal::RpcMethod;

RpcMethod::RpcType TypeOfCall(const google::protobuf::MethodDescriptor& method) {
  if (method.client_streaming()) {
    return method.server_streaming() ? RpcMethod::BIDI_STREAMING : RpcMethod::CLIENT_STREAMING;
  }
  return method.server_streaming() ? RpcMethod::SERVER_STREAMING : RpcMethod::NORMAL_RPC;
}

}  // namespace

const google::protobuf::MethodDescriptor& GuardedService::Find(
    const char* name, Streams streams, const google::protobuf::Descriptor* request,
    const google::protobuf::Descriptor* response) const {
  const Method* method = service_.FindMethodByName(name);
  CHECK(method != nullptr) << service_.full_name() << " has no call " << name;
  CHECK_EQ(method->client_streaming(), streams.reads) << name;
  CHECK_EQ(method->server_streaming(), streams.writes) << name;
  CHECK(request == nullptr || request == method->input_type()) << name;
  CHECK(response == nullptr || response == method->output_type()) << name;
  return *method;
}

void GuardedService::Add(const Method& method, grpc::internal::MethodHandler* handler) {
  const int index = static_cast<int>(paths_.size());
  paths_.push_back(absl::StrCat("/", service_.full_name(), "/", method.name()));
  AddMethod(new grpc::internal::RpcServiceMethod(paths_.back().c_str(), TypeOfCall(method),
                                                 /*handler=*/nullptr));
  MarkMethodCallback(index, handler);
}

}  // namespace corbslam::services

#include "services/runtime/callback_threads.h"

#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <memory>

namespace corbslam {
namespace {

// A channel that leads nowhere, and a call on it: with that it has a share in the threads.
struct Keeper {
  Keeper() {
    const grpc::Slice nothing;
    request = grpc::ByteBuffer(&nothing, 1);
    stub.UnaryCall(&context, "/corbslam/nothing", grpc::StubOptions(), &request, &response,
                   [](const grpc::Status&) {});
  }

  std::shared_ptr<grpc::Channel> channel = grpc::CreateCustomChannel("", nullptr, {});
  grpc::GenericStub stub{channel};
  grpc::ClientContext context;
  grpc::ByteBuffer request;
  grpc::ByteBuffer response;
};

}  // namespace

void KeepCallbackThreads() {
  // Never destroyed.
  static Keeper& keeper = *new Keeper;
  static_cast<void>(keeper);
}

}  // namespace corbslam

#include "services/runtime/callback_threads.h"

#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <memory>

namespace corbslam::services {
namespace {

// Holds a channel that leads nowhere, and a call on it, which makes it a user of the threads.
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
  // The keeper is never destroyed.
  static Keeper& keeper = *new Keeper;
  static_cast<void>(keeper);
}

}  // namespace corbslam::services

#include "services/client/remote/health_client.h"

#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/convert/status.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Says what an answer other than SERVING means. Field 1 has the number, and an empty message 0.
std::string DescribeAnswer(const std::string& answer) {
  if (answer == "\x08\x02") return "it answers NOT_SERVING";
  if (answer == "\x08\x03") return "it answers that it has no such service (SERVICE_UNKNOWN)";
  if (answer.empty()) return "it answers that it does not know (UNKNOWN)";
  return absl::StrCat("it answers what is no health: \"", absl::CHexEscape(answer.substr(0, 40)),
                      "\"");
}

}  // namespace

absl::Status CheckHealth(const std::shared_ptr<grpc::Channel>& channel, const std::string& service,
                         absl::Duration timeout) {
  if (service.size() > 127) {
    return absl::InvalidArgumentError(
        absl::StrCat("a service's name has ", service.size(), " characters, 127 is the limit"));
  }
  // Debian has no grpc/health/v1/health.proto, so the messages are written by hand: the request's
  // field 1 is the service's name, the answer's field 1 is 1 for SERVING.
  const grpc::Slice bytes(
      absl::StrCat("\x0a", std::string(1, static_cast<char>(service.size())), service));
  const grpc::ByteBuffer request(&bytes, 1);
  grpc::GenericStub stub(channel);
  grpc::CompletionQueue queue;
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + timeout));
  const auto call =
      stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", request, &queue);
  call->StartCall();
  grpc::ByteBuffer response;
  grpc::Status status;
  call->Finish(&response, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  RETURN_IF_ERROR(FromGrpcStatus(status));
  grpc::Slice slice;
  std::string answer;
  if (response.DumpToSingleSlice(&slice).ok()) {
    answer.assign(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  if (answer == "\x08\x01") return absl::OkStatus();
  return absl::FailedPreconditionError(DescribeAnswer(answer));
}

}  // namespace corbslam::services

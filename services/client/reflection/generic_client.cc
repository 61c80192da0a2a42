#include "services/client/reflection/generic_client.h"

#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/descriptor_database.h>
#include <google/protobuf/util/json_util.h>
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "reflection.pb.h"
#include "services/convert/status.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using google::protobuf::FileDescriptorProto;

grpc::ByteBuffer ToBuffer(const std::string& bytes) {
  const grpc::Slice slice(bytes);
  return {&slice, 1};
}

std::string ToString(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  buffer.Dump(&slices).ok();
  std::string bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

// Sends one message and receives all messages until the call ends.
absl::StatusOr<std::vector<std::string>> CallBytes(const std::shared_ptr<grpc::Channel>& channel,
                                                   const std::string& path,
                                                   const std::string& request,
                                                   const GenericCallOptions& options = {}) {
  grpc::GenericStub stub(channel);
  grpc::CompletionQueue queue;
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + options.max_time));
  const auto call = stub.PrepareCall(&context, path, &queue);
  // Only one operation runs at a time, so that the next event is always its end.
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  call->StartCall(nullptr);
  bool open = wait();
  if (open) {
    call->WriteLast(ToBuffer(request), grpc::WriteOptions(), nullptr);
    open = wait();
  }
  std::vector<std::string> responses;
  while (open) {
    grpc::ByteBuffer response;
    call->Read(&response, nullptr);
    open = wait();
    if (open) responses.push_back(ToString(response));
  }
  grpc::Status status;
  call->Finish(&status, nullptr);
  wait();
  queue.Shutdown();
  while (wait()) {
  }
  const bool cut = status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED;
  if (!cut || !options.may_be_cut) RETURN_IF_ERROR(FromGrpcStatus(status));
  return responses;
}

absl::StatusOr<reflection::ReflectionResponse> AskReflection(
    const std::shared_ptr<grpc::Channel>& channel, const reflection::ReflectionRequest& request,
    const GenericCallOptions& options = {}) {
  ASSIGN_OR_RETURN(
      const std::vector<std::string> answers,
      CallBytes(channel, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                request.SerializeAsString(), options));
  reflection::ReflectionResponse response;
  if (answers.empty() || !response.ParseFromString(answers[0])) {
    return absl::DataLossError("the server's reflection gave no answer");
  }
  if (response.has_error()) {
    return absl::Status(static_cast<absl::StatusCode>(response.error().code()),
                        response.error().message());
  }
  return response;
}

class ReflectionDatabase : public google::protobuf::DescriptorDatabase {
 public:
  explicit ReflectionDatabase(std::shared_ptr<grpc::Channel> channel)
      : channel_(std::move(channel)) {}

  bool FindFileByName(const std::string& name, FileDescriptorProto* output) override {
    reflection::ReflectionRequest request;
    request.set_file_by_filename(name);
    return Fetch(request, output);
  }
  bool FindFileContainingSymbol(const std::string& symbol, FileDescriptorProto* output) override {
    reflection::ReflectionRequest request;
    request.set_file_containing_symbol(symbol);
    return Fetch(request, output);
  }
  bool FindFileContainingExtension(const std::string&, int, FileDescriptorProto*) override {
    return false;
  }

 private:
  // The first file of an answer is the one that was asked for.
  bool Fetch(const reflection::ReflectionRequest& request, FileDescriptorProto* output) {
    const auto response = AskReflection(channel_, request);
    return response.ok() && response->files().files_size() > 0 &&
           output->ParseFromString(response->files().files(0));
  }

  const std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace

GenericClient::GenericClient(std::shared_ptr<grpc::Channel> channel)
    : channel_(channel),
      database_(std::make_unique<ReflectionDatabase>(channel)),
      pool_(database_.get()),
      factory_(&pool_) {}

GenericClient::~GenericClient() = default;

absl::StatusOr<std::vector<std::string>> GenericClient::ListServices(absl::Duration max_time) {
  reflection::ReflectionRequest request;
  request.set_list_services("*");
  GenericCallOptions options;
  options.max_time = max_time;
  ASSIGN_OR_RETURN(const reflection::ReflectionResponse response,
                   AskReflection(channel_, request, options));
  std::vector<std::string> names;
  for (const auto& service : response.services().services()) names.push_back(service.name());
  return names;
}

absl::StatusOr<std::vector<std::string>> GenericClient::ListMethods(const std::string& service) {
  const google::protobuf::ServiceDescriptor* descriptor = pool_.FindServiceByName(service);
  if (descriptor == nullptr) {
    return absl::NotFoundError(absl::StrCat("the server has no service ", service));
  }
  std::vector<std::string> names;
  for (int i = 0; i < descriptor->method_count(); ++i) {
    names.push_back(descriptor->method(i)->name());
  }
  return names;
}

absl::StatusOr<std::vector<std::string>> GenericClient::Call(const std::string& method,
                                                             const std::string& request_json,
                                                             const GenericCallOptions& options) {
  const google::protobuf::MethodDescriptor* descriptor =
      pool_.FindMethodByName(absl::StrReplaceAll(method, {{"/", "."}}));
  if (descriptor == nullptr) {
    return absl::NotFoundError(absl::StrCat("the server has no method ", method));
  }
  const std::unique_ptr<google::protobuf::Message> request(
      factory_.GetPrototype(descriptor->input_type())->New());
  const auto parsed = google::protobuf::util::JsonStringToMessage(request_json, request.get());
  if (!parsed.ok()) return absl::InvalidArgumentError(parsed.ToString());
  ASSIGN_OR_RETURN(
      const std::vector<std::string> answers,
      CallBytes(channel_, absl::StrCat("/", method), request->SerializeAsString(), options));
  std::vector<std::string> responses;
  for (const std::string& answer : answers) {
    const std::unique_ptr<google::protobuf::Message> response(
        factory_.GetPrototype(descriptor->output_type())->New());
    if (!response->ParseFromString(answer)) return absl::DataLossError("an unreadable response");
    google::protobuf::util::JsonPrintOptions print;
    print.add_whitespace = true;
    print.always_print_primitive_fields = options.defaults;
    responses.emplace_back();
    const auto printed =
        google::protobuf::util::MessageToJsonString(*response, &responses.back(), print);
    if (!printed.ok()) return absl::DataLossError(printed.ToString());
  }
  return responses;
}

}  // namespace corbslam::services

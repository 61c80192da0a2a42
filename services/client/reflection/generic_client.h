// Calls any method of a server that has reflection on, without knowing its protos.
#ifndef CORBSLAM_SERVICES_CLIENT_REFLECTION_GENERIC_CLIENT_H_
#define CORBSLAM_SERVICES_CLIENT_REFLECTION_GENERIC_CLIENT_H_

#include <google/protobuf/descriptor.h>
#include <google/protobuf/dynamic_message.h>
#include <grpcpp/channel.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace corbslam::services {

struct GenericCallOptions {
  absl::Duration max_time = absl::Seconds(30);
  // True: what came within `max_time` is the answer, for streams that don't end. False:
  // DEADLINE_EXCEEDED.
  bool may_be_cut = false;
  // True: fields that have their default value are printed, too.
  bool defaults = true;
};

// A client of one server. Not thread-safe. All calls block.
class GenericClient {
 public:
  explicit GenericClient(std::shared_ptr<grpc::Channel> channel);
  ~GenericClient();

  // Returns full names.
  absl::StatusOr<std::vector<std::string>> ListServices(
      absl::Duration max_time = GenericCallOptions().max_time);
  // Returns the names of the methods of one service, for example "corbslam.v1.MapStore". NOT_FOUND
  // if the server has no such service.
  absl::StatusOr<std::vector<std::string>> ListMethods(const std::string& service);
  // Calls `method`, for example "corbslam.v1.MapStore/GetMission"; the request and each response
  // are JSON.
  absl::StatusOr<std::vector<std::string>> Call(const std::string& method,
                                                const std::string& request_json,
                                                const GenericCallOptions& options = {});

 private:
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<google::protobuf::DescriptorDatabase> database_;
  google::protobuf::DescriptorPool pool_;
  google::protobuf::DynamicMessageFactory factory_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REFLECTION_GENERIC_CLIENT_H_

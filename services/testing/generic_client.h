// Calls any method of a server that has reflection on, knowing no proto of it.
#ifndef CORBSLAM_SERVICES_TESTING_GENERIC_CLIENT_H_
#define CORBSLAM_SERVICES_TESTING_GENERIC_CLIENT_H_

#include <google/protobuf/descriptor.h>
#include <google/protobuf/dynamic_message.h>
#include <grpcpp/channel.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam {

// Not thread-safe. All calls block.
class GenericClient {
 public:
  explicit GenericClient(std::shared_ptr<grpc::Channel> channel);
  ~GenericClient();

  // Full names.
  absl::StatusOr<std::vector<std::string>> ListServices();
  // `method` as "corbslam.v1.MapStore/GetMission"; the request and each response as JSON.
  absl::StatusOr<std::vector<std::string>> Call(const std::string& method,
                                                const std::string& request_json);

 private:
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<google::protobuf::DescriptorDatabase> database_;
  google::protobuf::DescriptorPool pool_;
  google::protobuf::DynamicMessageFactory factory_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TESTING_GENERIC_CLIENT_H_

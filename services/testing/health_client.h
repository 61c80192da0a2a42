// Asks any server how it is.
#ifndef CORBSLAM_SERVICES_TESTING_HEALTH_CLIENT_H_
#define CORBSLAM_SERVICES_TESTING_HEALTH_CLIENT_H_

#include <grpcpp/channel.h>

#include <memory>
#include <string>

#include "absl/status/status.h"

namespace corbslam {

// grpc.health.v1.Health/Check. OK where it says SERVING, FAILED_PRECONDITION for any other answer;
// otherwise how the call failed.
absl::Status CheckHealth(const std::shared_ptr<grpc::Channel>& channel, const std::string& service);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TESTING_HEALTH_CLIENT_H_

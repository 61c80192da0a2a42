// Asks any server for its health.
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_HEALTH_CLIENT_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_HEALTH_CLIENT_H_

#include <grpcpp/channel.h>

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Calls grpc.health.v1.Health/Check. Returns OK if the server says SERVING, FAILED_PRECONDITION for
// any other answer, and otherwise how the call failed. A service's name has less than 128
// characters.
absl::Status CheckHealth(const std::shared_ptr<grpc::Channel>& channel, const std::string& service,
                         absl::Duration timeout = absl::Seconds(10));

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_HEALTH_CLIENT_H_

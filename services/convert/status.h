// Converts absl::Status and grpc::Status, which share their codes.
#ifndef CORBSLAM_SERVICES_CONVERT_STATUS_H_
#define CORBSLAM_SERVICES_CONVERT_STATUS_H_

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"

namespace corbslam::services {

inline grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  return {static_cast<grpc::StatusCode>(status.code()), std::string(status.message())};
}

// Returns the server's message, or what it means that there are none.
inline std::string MessageOf(const grpc::Status& status) {
  if (!status.error_message().empty()) return status.error_message();
  return status.error_code() == grpc::StatusCode::UNIMPLEMENTED
             ? "the server there does not know this call: is it another kind of server, or older?"
             : "the server there says no more";
}

inline absl::Status FromGrpcStatus(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  return absl::Status(static_cast<absl::StatusCode>(status.error_code()), MessageOf(status));
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_STATUS_H_

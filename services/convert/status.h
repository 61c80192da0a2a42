// Converts absl::Status and grpc::Status, which share their codes. Where a mission is that another
// store has (slam/exchange/mission_elsewhere.h) crosses the wire, as proto/corbslam/v1/fleet.proto
// says it.
#ifndef CORBSLAM_SERVICES_CONVERT_STATUS_H_
#define CORBSLAM_SERVICES_CONVERT_STATUS_H_

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"

namespace corbslam::services {

// Returns the bytes of a StatusDetails; empty: there is nothing to be said.
std::string DetailsOf(const absl::Status& status);
// Adds what such bytes say; what can't be read says nothing.
absl::Status WithDetails(absl::Status status, const std::string& details);

inline grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  return {static_cast<grpc::StatusCode>(status.code()), std::string(status.message()),
          DetailsOf(status)};
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
  return WithDetails(
      absl::Status(static_cast<absl::StatusCode>(status.error_code()), MessageOf(status)),
      status.error_details());
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_STATUS_H_

// Sets deadlines of calls of a map store, and says for people how the calls ended.
#ifndef CORBSLAM_SERVICES_CLIENT_STORE_CALL_STATUS_H_
#define CORBSLAM_SERVICES_CLIENT_STORE_CALL_STATUS_H_

#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>

#include <chrono>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/convert/status.h"
#include "slam/exchange/mission_elsewhere.h"

namespace corbslam::services {

// Sets the deadline of a call that answers at once.
inline void SetDeadline(grpc::ClientContext& context) {
  context.set_deadline(absl::ToChronoTime(absl::Now() + absl::Seconds(60)));
}

// Sets the deadline of a call that reads a whole map or trajectory, maybe over a slow link, and
// lets it wait for a store that may be starting.
inline void SetStreamDeadline(grpc::ClientContext& context) {
  context.set_deadline(absl::ToChronoTime(absl::Now() + absl::Minutes(10)));
  context.set_wait_for_ready(true);
}

// Returns the status with the name of the call that met the error.
inline absl::Status ToStatus(const grpc::Status& status, absl::string_view call) {
  if (status.ok()) return absl::OkStatus();
  return WithMessage(FromGrpcStatus(status), absl::StrCat(call, ": ", MessageOf(status)));
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_STORE_CALL_STATUS_H_

// What a server shows of itself, to whoever connects.
#ifndef CORBSLAM_SERVICES_DOCTOR_TLS_PROBE_H_
#define CORBSLAM_SERVICES_DOCTOR_TLS_PROBE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace corbslam {

// "HOST" of "HOST:PORT" or "[HOST]:PORT".
std::string HostOf(const std::string& address);

// Whether somebody listens there. UNAVAILABLE says what the network said.
absl::Status ProbeTcp(const std::string& address, absl::Duration timeout);

// The certificates that the server sends, as PEM, its own first; nothing of them is verified.
// UNAVAILABLE: it speaks no TLS, or nobody listens.
absl::StatusOr<std::string> FetchCertificates(const std::string& address, absl::Duration timeout);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_DOCTOR_TLS_PROBE_H_

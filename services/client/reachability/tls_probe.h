// Fetches the certificates that a server shows to whoever connects.
#ifndef CORBSLAM_SERVICES_CLIENT_REACHABILITY_TLS_PROBE_H_
#define CORBSLAM_SERVICES_CLIENT_REACHABILITY_TLS_PROBE_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/runtime/address.h"

namespace corbslam::services {

// Returns the certificates that the server sends, as PEM, its own first; none of them is verified.
// UNAVAILABLE if the server speaks no TLS, or nobody listens.
absl::StatusOr<std::string> FetchCertificates(const HostPort& address, absl::Duration timeout);

// Shows the certificate to the server, as PEM with its key (both empty: none), and waits for its
// first byte. Returns what the server answers instead, as "unknown ca"; "" if it hangs up without a
// word, and nullopt if it takes the caller or can't be asked.
std::optional<std::string> ProbeOwnCertificate(const HostPort& address,
                                               const std::string& certificate_pem,
                                               const std::string& key_pem, absl::Duration timeout);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REACHABILITY_TLS_PROBE_H_

// Makes a certificate that nobody trusts, for as long as there is no other.
#ifndef CORBSLAM_SERVICES_SECURITY_PLACEHOLDER_PAIR_H_
#define CORBSLAM_SERVICES_SECURITY_PLACEHOLDER_PAIR_H_

#include "absl/status/statusor.h"
#include "services/security/pem_files.h"

namespace corbslam::services {

// Returns a key that is drawn now and its certificate, which it signed itself: gRPC aborts on an
// empty key, and whoever is shown this pair refuses it. As an authority, nobody's certificate is of
// it. INTERNAL if OpenSSL can't make it.
absl::StatusOr<KeyPair> MakePlaceholderPair();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_PLACEHOLDER_PAIR_H_

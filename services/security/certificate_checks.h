// Checks the files that TLS flags name, and certificates that servers showed.
#ifndef CORBSLAM_SERVICES_SECURITY_CERTIFICATE_CHECKS_H_
#define CORBSLAM_SERVICES_SECURITY_CERTIFICATE_CHECKS_H_

#include <string>

#include "absl/time/time.h"
#include "services/security/finding.h"
#include "services/security/security_options.h"

namespace corbslam::services {

// Checks certificates at the time `now`: one that has not begun or has expired fails, less than 14
// days left is a warning. If `pem` holds several, the one that ends first counts.
Finding CheckExpiry(const std::string& check, const std::string& pem, absl::Time now);
// Checks that the chain in `pem` (a certificate, then those between) leads to one of the
// authorities.
Finding CheckChain(const std::string& check, const std::string& pem,
                   const std::string& authorities_pem);
// Checks that the certificate is for that host, a name or an address.
Finding CheckHost(const std::string& check, const std::string& pem, const std::string& host);

// Checks all that can be said of the flags alone: the files are readable, belong together, have not
// expired, and make a chain.
Findings CheckSecurityFiles(const SecurityOptions& options, absl::Time now);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_CERTIFICATE_CHECKS_H_

// Checks of the files that TLS flags name, and of certificates that were met.
#ifndef CORBSLAM_SERVICES_SECURITY_CERTIFICATE_CHECKS_H_
#define CORBSLAM_SERVICES_SECURITY_CERTIFICATE_CHECKS_H_

#include <string>

#include "absl/time/time.h"
#include "services/security/finding.h"
#include "services/security/security_options.h"

namespace corbslam {

// Certificates are looked at as they are at `now`: not begun or expired fails, less than 14 days
// left is a warning. Of several in a file, the one that ends first.
Finding CheckExpiry(const std::string& check, const std::string& pem, absl::Time now);
// The chain in `pem` (a certificate, then those between) leads to one of the authorities.
Finding CheckChain(const std::string& check, const std::string& pem,
                   const std::string& authorities_pem);
// The certificate is for that host, a name or an address.
Finding CheckHost(const std::string& check, const std::string& pem, const std::string& host);

// All that can be said of the flags alone: readable, belonging together, expiry, chain.
Findings CheckSecurityFiles(const SecurityOptions& options, absl::Time now);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SECURITY_CERTIFICATE_CHECKS_H_

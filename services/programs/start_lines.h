// Says in the log what a program is, once it runs: where it serves, for whom, and what it works on.
#ifndef CORBSLAM_SERVICES_PROGRAMS_START_LINES_H_
#define CORBSLAM_SERVICES_PROGRAMS_START_LINES_H_

#include <string>

#include "services/security/security_options.h"

namespace corbslam::services {

// Returns how a server is secured, such as "with TLS, to certificates and tokens".
std::string DescribeServing(const SecurityOptions& security);
// Returns how a server is called, such as "with TLS, by certificate alpha.pem".
std::string DescribeCalling(const SecurityOptions& security);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_START_LINES_H_

// Checks a server from this machine.
#ifndef CORBSLAM_SERVICES_TOOL_DOCTOR_SERVER_CHECKS_H_
#define CORBSLAM_SERVICES_TOOL_DOCTOR_SERVER_CHECKS_H_

#include <set>
#include <string>

#include "absl/time/time.h"
#include "services/security/finding.h"
#include "services/security/security_options.h"

namespace corbslam::services {

// Compares the methods of one service: those that this program knows with those of the server.
Finding CompareMethods(const std::string& name, const std::set<std::string>& own,
                       const std::set<std::string>& theirs);

// Checks whether the server is reached, shows a good certificate, says that it is ready, and speaks
// the same interface as this program: `service` is a name as "corbslam.v1.MapStore". Of a map store
// it also checks whether fusion workers take its requests. What follows from a failure is not
// checked. Findings are called "NAME ADDRESS".
Findings CheckServer(const std::string& name, const std::string& address,
                     const std::string& service, const SecurityOptions& options, absl::Time now);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_DOCTOR_SERVER_CHECKS_H_

// Checks of a server from here.
#ifndef CORBSLAM_SERVICES_TOOL_DOCTOR_SERVER_CHECKS_H_
#define CORBSLAM_SERVICES_TOOL_DOCTOR_SERVER_CHECKS_H_

#include <set>
#include <string>

#include "absl/time/time.h"
#include "services/security/finding.h"
#include "services/security/security_options.h"

namespace corbslam {

// Of one service: the names that each side knows.
Finding CompareMethods(const std::string& name, const std::set<std::string>& own,
                       const std::set<std::string>& theirs);

// Whether it is reached, shows a good certificate, says that it is ready, and speaks the same
// interface as this program: `service` as "corbslam.v1.MapStore"; of a map store whether fusion
// workers take its requests, too. What follows from a failure is not looked at. Findings are called
// "NAME ADDRESS".
Findings CheckServer(const std::string& name, const std::string& address,
                     const std::string& service, const SecurityOptions& options, absl::Time now);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TOOL_DOCTOR_SERVER_CHECKS_H_

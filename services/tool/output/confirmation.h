// Asks people before something goes for good.
#ifndef CORBSLAM_SERVICES_TOOL_OUTPUT_CONFIRMATION_H_
#define CORBSLAM_SERVICES_TOOL_OUTPUT_CONFIRMATION_H_

#include <cstdio>
#include <string>

#include "absl/status/status.h"

namespace corbslam::services {

// Returns true if somebody sits at a terminal, who can be asked.
bool SomebodyIsThere();

// Asks on `out` whether it is meant, and reads the answer, "yes", from `in`. CANCELLED for any
// other.
absl::Status Confirm(const std::string& question, std::FILE* in, std::FILE* out);

// Asks at the terminal, unless `is_sure` (--yes) or nobody is there: a script means what it says.
absl::Status ConfirmLoss(const std::string& question, bool is_sure);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_OUTPUT_CONFIRMATION_H_

// Checks of this machine.
#ifndef CORBSLAM_SERVICES_TOOL_DOCTOR_LOCAL_CHECKS_H_
#define CORBSLAM_SERVICES_TOOL_DOCTOR_LOCAL_CHECKS_H_

#include <string>

#include "absl/time/time.h"
#include "services/security/finding.h"

namespace corbslam {

// `now` lies after this program was made, and something keeps the clock right. Certificates and
// tokens are judged by it; maps are not (each robot's clock is its own).
Findings CheckClock(absl::Time now);
// Every byte.
Finding CheckVocabularyFile(const std::string& path);
// Can be written to (a file is made and removed), and has room: less than 1 GiB is a warning, less
// than a store leaves free (64 MiB) a failure. A folder that is not there yet: that of its parents
// which is.
Findings CheckDataFolder(const std::string& path);
// What is known of it, a finding a line, and what looks wrong in its files and in a sample of its
// frames, larger than the one that a robot looks at. With `strict` warnings are failures.
Findings CheckSource(const std::string& source, bool strict);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TOOL_DOCTOR_LOCAL_CHECKS_H_

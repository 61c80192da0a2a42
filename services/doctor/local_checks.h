// Checks of this machine.
#ifndef CORBSLAM_SERVICES_DOCTOR_LOCAL_CHECKS_H_
#define CORBSLAM_SERVICES_DOCTOR_LOCAL_CHECKS_H_

#include <string>

#include "absl/time/time.h"
#include "services/doctor/finding.h"

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
// Its first and last frames are read.
Finding CheckSource(const std::string& source);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_DOCTOR_LOCAL_CHECKS_H_

// Checks this machine: its clock, files and folders.
#ifndef CORBSLAM_SERVICES_TOOL_DOCTOR_LOCAL_CHECKS_H_
#define CORBSLAM_SERVICES_TOOL_DOCTOR_LOCAL_CHECKS_H_

#include <string>

#include "absl/time/time.h"
#include "services/security/finding.h"

namespace corbslam::services {

// Checks that `now` lies after this program was made, and that something keeps the clock right.
// Certificates and tokens are judged by this clock; maps are not (each robot's clock is its own).
Findings CheckClock(absl::Time now);
// Reads every byte of the file.
Finding CheckVocabularyFile(const std::string& path);
// Checks that the folder can be written to (a file is made and removed) and has room: less than 1
// GiB is a warning, less than a store leaves free (64 MiB) a failure. Where the folder does not
// exist yet, its nearest parent that exists is checked.
Findings CheckDataFolder(const std::string& path);
// Returns what is known of the source, a finding a line, and what looks wrong in its files and in a
// sample of its frames, which is larger than the sample that a robot looks at. With `strict`
// warnings are failures.
Findings CheckSource(const std::string& source, bool strict);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_DOCTOR_LOCAL_CHECKS_H_

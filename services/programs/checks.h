// Checks what --validate-config checks. Nothing is made or changed. Errors name the flag.
#ifndef CORBSLAM_SERVICES_PROGRAMS_CHECKS_H_
#define CORBSLAM_SERVICES_PROGRAMS_CHECKS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "services/programs/observe_flags.h"

namespace corbslam::services {

// Checks that the address is HOST:PORT to listen on.
absl::Status CheckFlagAddress(absl::string_view flag, const std::string& address);
// Checks that the address is HOST:PORT of a server to connect to.
absl::Status CheckFlagServer(absl::string_view flag, const std::string& address);
// Checks that a folder can be written to, or that it can be made.
absl::Status CheckFolder(absl::string_view flag, const std::string& path);
// Checks the folder of a file that is going to be written.
absl::Status CheckFolderOf(const std::string& file);
// Checks the address that metrics are served on.
std::vector<absl::Status> CheckObserving(const ObserveFlags& flags);
// Reads every byte of the file.
absl::Status CheckVocabulary(const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_CHECKS_H_

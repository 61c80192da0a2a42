// What --validate-config looks at. Nothing is made or changed. Errors name the flag.
#ifndef CORBSLAM_SERVICES_PROGRAMS_CHECKS_H_
#define CORBSLAM_SERVICES_PROGRAMS_CHECKS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "services/programs/observe_flags.h"

namespace corbslam {

// HOST:PORT to listen on.
absl::Status CheckFlagAddress(absl::string_view flag, const std::string& address);
// HOST:PORT of a server to connect to.
absl::Status CheckFlagServer(absl::string_view flag, const std::string& address);
// A folder that can be written to, or that can be made.
absl::Status CheckFolder(absl::string_view flag, const std::string& path);
// The folder of a file that is going to be written.
absl::Status CheckFolderOf(const std::string& file);
// Where metrics and traces go.
std::vector<absl::Status> CheckObserving(const ObserveFlags& flags);
// Every byte of it.
absl::Status CheckVocabulary(const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_CHECKS_H_

// Reads the values of a source's options.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_OPTION_VALUES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_OPTION_VALUES_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Returns INVALID_ARGUMENT, which names the option, its value and what it wants.
absl::Status BadOption(absl::string_view key, absl::string_view value, absl::string_view wanted);

// Reads a number from `least` to `most`; else returns BadOption.
absl::Status ParseReal(absl::string_view key, absl::string_view value, double least, double most,
                       double& number);

// Reads 0 or 1; an option without a value is 1. Else returns BadOption.
absl::Status ParseFlag(absl::string_view key, absl::string_view value, bool& flag);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_OPTION_VALUES_H_

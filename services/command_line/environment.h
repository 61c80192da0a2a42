// Reads flags from environment variables: --data-dir of map_store is CORBSLAM_MAP_STORE_DATA_DIR.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_ENVIRONMENT_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_ENVIRONMENT_H_

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "absl/strings/string_view.h"

namespace corbslam::services {

// Returns "CORBSLAM_MAP_STORE_" for "map_store".
std::string EnvironmentPrefix(absl::string_view program);
// Returns the variable of an option that can be configured, by its first long name; "" for others.
std::string EnvironmentName(absl::string_view prefix, const CLI::Option& option);

// Calls `visit` for each option of the program and of all its commands.
void ForEachOption(CLI::App& app, const std::function<void(CLI::App&, CLI::Option&)>& visit);

// Lets the environment set all options. The caller must have added them all.
void ReadFromEnvironment(CLI::App& app, const std::string& prefix);
// Returns the variables with the prefix that mean no option, as text for people; "" if there are
// none. Those that Kubernetes sets for a service of such a name (..._SERVICE_HOST, ..._PORT, ...)
// are not ours.
std::string DescribeUnknownVariables(CLI::App& app, const std::string& prefix);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_ENVIRONMENT_H_

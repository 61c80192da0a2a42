// Advises somebody who typed no command, an unknown command or an unknown flag.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_ADVICE_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_ADVICE_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace corbslam::services {

// Returns the one of `known` that takes the fewest changed, added, missing or exchanged letters to
// make `typed`; empty where each takes more than a third of the letters.
std::string FindNearest(absl::string_view typed, const std::vector<std::string>& known);

// Returns for an app whose parsing failed the commands that there are, if one was needed, and the
// one that was meant, if there is a near one. Returns an empty text if the failure was of another
// kind.
std::string DescribeWrongCommand(const CLI::App& app);

// Returns the same for the first flag that none of the commands knows; empty if all are known.
std::string DescribeWrongFlag(const CLI::App& app);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_ADVICE_H_

// What to say to someone who typed no command, or one that is none, or a flag that is none.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_ADVICE_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_ADVICE_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace corbslam {

// Returns the one of `words` that takes the fewest changed, added, missing or exchanged letters to
// make `typed`; empty where each takes more than a third of the letters.
std::string FindNearest(absl::string_view typed, const std::vector<std::string>& words);

// Of an app whose parsing failed: the commands that there are, where one was needed; the one that
// was meant, where there is a near one. Empty where the failure was of another kind.
std::string DescribeWrongCommand(const CLI::App& app);

// Likewise of the first flag that none of the commands knows; empty: all are known.
std::string DescribeWrongFlag(const CLI::App& app);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_ADVICE_H_

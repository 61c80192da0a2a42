// Reads and writes the options of a source's spec that say what its files leave open
// (SourceOpening).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_OPENING_OPTIONS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_OPENING_OPTIONS_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {

// Returns the options that mean something for the layout, spelled with '_'.
std::vector<absl::string_view> OpeningOptionNames(SourceLayout layout);
bool IsOpeningOption(SourceLayout layout, absl::string_view key);

// Returns INVALID_ARGUMENT, naming the option and its value, where it can't be applied.
absl::Status ApplyOpeningOption(absl::string_view key, absl::string_view value,
                                SourceOpening& opening);

// Returns name and value of the options that differ from their defaults.
std::vector<std::pair<std::string, std::string>> FormatOpening(const SourceOpening& opening);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_OPENING_OPTIONS_H_

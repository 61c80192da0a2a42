// A simulation's options as text: "seed=7", "blackout=10:2".
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATION_OPTIONS_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATION_OPTIONS_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "services/simulation/sequence/simulation_spec.h"

namespace corbslam {

// Parses "city", "path" or "floor". INVALID_ARGUMENT names those that there are.
absl::StatusOr<SimulatedWorld> ParseSimulatedWorld(absl::string_view name);

bool IsSimulationOption(absl::string_view key);
std::vector<absl::string_view> SimulationOptionNames();

// `key` must be an option. INVALID_ARGUMENT names it, its value and what it wants.
absl::Status ApplySimulationOption(absl::string_view key, absl::string_view value,
                                   SimulationSpec& spec);

// Returns the options that differ from the defaults, in the order of SimulationOptionNames; applied
// to the defaults they give `spec` again.
std::vector<std::pair<std::string, std::string>> FormatSimulationOptions(
    const SimulationSpec& spec);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATION_OPTIONS_H_

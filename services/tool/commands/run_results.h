// Writes what a run leaves behind.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_RUN_RESULTS_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_RUN_RESULTS_H_

#include <string>

#include "absl/status/status.h"
#include "services/tool/run/mission_run.h"

namespace corbslam::services {

// Adds the accuracy to the outcome's report, and writes trajectories, report.json, report.md,
// report.html and map.png into the folder. `own` is the robot drawn as own. UNAVAILABLE names a
// file that can't be written.
absl::Status WriteResults(const std::string& folder, const std::string& own,
                          MissionOutcome& outcome);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_RUN_RESULTS_H_

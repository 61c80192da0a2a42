// Plays the robots of `corbslam run`, and writes what came of it.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_PLAY_RUN_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_PLAY_RUN_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "services/tool/run/mission_run.h"

namespace corbslam::services {

struct RunPlan {
  MissionRunOptions mission;  // With its robots.
  std::vector<std::string> sources;
  std::string own;
  std::string out;
  size_t from_frame = 15;
  bool is_from_frame_given = false;
  // True: the same robots play a second time, alone, as the mission NAME-alone.
  bool company = false;
  std::string command_line;
};

// Prints what it does. Returns an error if something is wrong with the plan before anything starts,
// and if a robot failed, although the report is written then.
absl::Status PlayRun(RunPlan plan);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_PLAY_RUN_H_

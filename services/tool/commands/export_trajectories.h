// Implements `corbslam mission export` of trajectories.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_EXPORT_TRAJECTORIES_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_EXPORT_TRAJECTORIES_H_

#include <grpcpp/channel.h>

#include <memory>

#include "absl/status/status.h"
#include "services/tool/commands/mission_arguments.h"

namespace corbslam::services {

// Writes the trajectory of one robot to the file, or those of all robots to files of a folder, and
// beside them a README that says what they hold. A robot whose local maps repeat times has several
// files (trajectory_files.h).
absl::Status ExportTrajectories(const MissionArguments& arguments,
                                const std::shared_ptr<grpc::Channel>& channel);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_EXPORT_TRAJECTORIES_H_

// Implements `corbslam mission export --format mcap`.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_EXPORT_MCAP_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_EXPORT_MCAP_H_

#include <grpcpp/channel.h>

#include <memory>

#include "absl/status/status.h"
#include "services/tool/commands/mission_arguments.h"

namespace corbslam::services {

// Writes the mission's recording, and beside it a README that says what it holds. A store that is
// older than a call that this needs makes the recording shorter, and that is said.
absl::Status ExportMcap(const MissionArguments& arguments,
                        const std::shared_ptr<grpc::Channel>& channel);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_EXPORT_MCAP_H_

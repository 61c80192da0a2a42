// Opens what a robot plays: a sequence, which is looked into before, or a live camera.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_ROBOT_SOURCE_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_ROBOT_SOURCE_H_

#include <memory>

#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_description.h"
#include "client_agent/source/source_finding.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::services {

struct RobotSource {
  std::unique_ptr<client_agent::FrameStream> stream;
  client_agent::SourceDescription description;
  // Warnings from opening a sequence and from a sample of its frames. A camera's stream has its
  // own.
  client_agent::SourceFindings warnings;
};

// Returns INVALID_ARGUMENT with every error that was found, and with every warning too if `strict`.
// A camera runs from then on, and its first frames are judged when they come (JudgedStream); one
// that waits for who drives it waits until `stop` (CANCELLED). Selecting or disturbing a camera's
// frames is INVALID_ARGUMENT.
absl::StatusOr<RobotSource> OpenRobotSource(const client_agent::SourceSpec& spec, bool strict,
                                            const absl::Notification& stop);

// Returns what OpenRobotSource would refuse, as far as that can be told without starting a camera.
absl::Status CheckRobotSource(const client_agent::SourceSpec& spec, bool strict);

// Logs the description, a line each, and the warnings as warnings.
void LogSource(const RobotSource& source);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_ROBOT_SOURCE_H_

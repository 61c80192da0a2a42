// Says what is wrong with a robot's flags, before it begins.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAG_CHECKS_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAG_CHECKS_H_

#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "client_agent/upload/feature_selection.h"
#include "services/client/remote/store_route.h"
#include "services/programs/robot/robot_source.h"
#include "services/programs/robot_flags.h"

namespace corbslam::services {

// Opens --source with --rig and --frames. CANCELLED where it was stopped while it waited for who
// drives its camera.
absl::StatusOr<RobotSource> OpenFlaggedSource(const RobotFlags& flags,
                                              const absl::Notification& stop);
// What goes up of a keyframe.
struct UploadChoice {
  client_agent::FeatureSelection features;
  int picture_width_px = 320;  // AgentOptions::picture_width_px.
};
absl::StatusOr<UploadChoice> ParseUpload(const RobotFlags& flags);
// Whether certificates, keys and tokens must be good now. A robot that starts does not end because
// one of them has expired: it maps, and takes a new one when that comes.
enum class Files { kMustBeGood, kMayCome };
SecurityOptions Bearing(SecurityOptions security, Files files);

// Returns null without --server.
absl::StatusOr<std::shared_ptr<StoreRoute>> MakeStoreRoute(const RobotFlags& flags, Files files);

// Checks how other programs on the robot reach it.
absl::Status CheckListenSecurity(const RobotFlags& flags, Files files);
// Checks what the map store may set.
absl::Status CheckSettable(const RobotFlags& flags);
// Checks places in the network and on disk, and flags that need others: in a moment.
std::vector<absl::Status> CheckPlaces(const RobotFlags& flags);
// Checks all, as --check does: files are read.
std::vector<absl::Status> CheckRobotFlags(const RobotFlags& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAG_CHECKS_H_

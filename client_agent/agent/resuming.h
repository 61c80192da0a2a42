// Finds the local map that a robot goes on with after a restart (docs/robot.md).
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_RESUMING_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_RESUMING_H_

#include "absl/status/statusor.h"
#include "client_agent/spool/spool.h"
#include "client_agent/upload/spooled_map.h"
#include "slam/camera/camera.h"
#include "slam/camera/recorded_camera.h"

namespace corbslam::client_agent {

// Returns OK if a map that was made with the cameras of `spooled_map` may go on with these;
// FAILED_PRECONDITION names what differs.
absl::Status CheckSameRig(const SpooledMap& spooled_map, const Camera& camera,
                          const RecordedCamera& recorded);

// Returns the newest local map that the spool keeps and that is open. NOT_FOUND: it keeps none.
// Anything else says why the local map can't go on: it is not all there, does not fit itself, or
// was made with another rig.
absl::StatusOr<SpooledMap> FindMapToResume(Spool& spool, const Camera& camera,
                                           const RecordedCamera& recorded);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_RESUMING_H_

// Writes trajectories in EuRoC's form: "#timestamp [ns],p_RS_R_x [m],...,q_RS_w [],...", a
// quaternion with w first.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_EUROC_FILE_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_EUROC_FILE_H_

#include <string>

#include "absl/status/status.h"
#include "slam/evaluation/trajectory.h"

namespace corbslam::services {

// Writes poses of the camera (EuRoC's own truth is the body's). slam/evaluation reads them back,
// with the identity as body_from_camera. UNAVAILABLE names the path.
absl::Status WriteEurocTrajectory(const Trajectory& trajectory, const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_EUROC_FILE_H_

// Writes where an agent's frames were to files.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_TRAJECTORIES_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_TRAJECTORIES_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client_agent/agent/agent.h"
#include "slam/camera/recorded_camera.h"
#include "slam/sensor/sensor.h"

namespace corbslam::services {

// Checks whether the calibration gives poses of the wanted frame: FAILED_PRECONDITION if not.
absl::Status CheckPosesOf(const SensorCalibration& calibration, PosesOf poses_of);

// Writes TUM files that say what their poses are of and in which frame. Local maps have frames of
// their own: the first one's poses go to `path`, the next one's to path.2 and so on. UNAVAILABLE
// names the path.
absl::Status WriteAgentTrajectories(const client_agent::Agent& agent,
                                    const SensorCalibration& calibration, PosesOf poses_of,
                                    const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_AGENT_TRAJECTORIES_H_

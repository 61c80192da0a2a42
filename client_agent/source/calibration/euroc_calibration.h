// Reads the sensor.yaml of a camera in EuRoC's ASL layout.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_EUROC_CALIBRATION_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_EUROC_CALIBRATION_H_

#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/calibration/stated_imu.h"
#include "slam/camera/rectification.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

// Camera::close_depth_m of EuRoC's recordings, in baselines.
inline constexpr double kEurocCloseDepth_baselines = 50;

struct EurocCamera {
  Rigid3d body_from_camera;  // The file's T_BS.
  RawCamera intrinsics;
  int width_px = 0;
  int height_px = 0;
};

struct EurocImu {
  Rigid3d body_from_imu;  // The file's T_BS.
  StatedImu stated;       // Without where the camera sits.
};

// Reads imu0/sensor.yaml; its rate and noise may be left out. Errors name the file and the field.
absl::StatusOr<EurocImu> ReadEurocImu(const std::string& sensor_yaml_path);

// Reads a camera with radial-tangential or equidistant distortion. Errors name the file and the
// field.
absl::StatusOr<EurocCamera> ReadEurocCamera(const std::string& sensor_yaml_path);

// Returns DIR/mav0 where that is there, else DIR.
std::string EurocRoot(const std::string& directory);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_EUROC_CALIBRATION_H_

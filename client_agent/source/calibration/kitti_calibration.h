// Reads the rectified stereo calibrations of KITTI: calib.txt and calib_cam_to_cam.txt.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_KITTI_CALIBRATION_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_KITTI_CALIBRATION_H_

#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

struct KittiCalibrationQuery {
  std::string path;
  // Names of the lines with the 3x4 projections of the rectified left and right camera: "P0", "P1".
  std::string left_row;
  std::string right_row;
  int width_px = 0;
  int height_px = 0;
  bool trust = false;  // The option ?trust-calibration.
};

struct FoundKittiCalibration {
  StereoCalibration calibration;
  SourceFindings findings;
};

// Returns NOT_FOUND where the file is not there. INVALID_ARGUMENT names file and line: a row that
// is missing or there twice, that is no projection of a rectified camera, two rows that are no pair
// (another focal length or principal row), a baseline or intrinsics that can't be.
absl::StatusOr<FoundKittiCalibration> ReadKittiCalibration(const KittiCalibrationQuery& query);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_KITTI_CALIBRATION_H_

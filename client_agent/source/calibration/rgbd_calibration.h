// Finds the calibration of an RGB-D recording: from a file, an option, or the recording's own name.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_RGBD_CALIBRATION_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_RGBD_CALIBRATION_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// What says which camera a recording is of, and the pictures it must fit.
struct RgbdCalibrationQuery {
  // The recording's folder, and those in which its pictures really lie where it is made of links.
  std::vector<std::string> folders;
  std::string file;           // The option ?calibration=FILE; empty: none.
  std::string camera;         // The option ?camera=NAME; empty: none.
  std::string first_picture;  // Its path, for messages.
  int width_px = 0;
  int height_px = 0;
  bool trust = false;  // The option ?trust-calibration.
};

struct FoundRgbdCalibration {
  RgbdCalibration calibration;
  std::string from;              // The file or the option that gave it.
  std::string depth_units_from;  // The file or the option that gave them.
  SourceFindings findings;
};

// Returns the first of these that there is: ?calibration, ?camera, and then for each folder in turn
// its calibration.yaml, its calibration.txt, a comment in its rgb.txt, depth.txt or groundtruth.txt
// that names the recording as TUM's files do ("# file: 'rgbd_dataset_freiburg1_xyz.bag'"), its own
// name if it is exactly one of the TUM benchmark's. calibration.yaml has fx, fy, cx, cy in pixels,
// and may have k1, k2, p1, p2, k3, depth_units_per_m (5000), width and height; calibration.txt is
// ETH3D's "fx fy cx cy". Returns NOT_FOUND, saying what to give, where there is none;
// INVALID_ARGUMENT, with file and field, for one that is not whole or can't be of these pictures.
absl::StatusOr<FoundRgbdCalibration> FindRgbdCalibration(const RgbdCalibrationQuery& query);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_RGBD_CALIBRATION_H_

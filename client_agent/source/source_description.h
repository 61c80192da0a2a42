// Describes what is known of a sequence before it is played, and where each part is known from.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_DESCRIPTION_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_DESCRIPTION_H_

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client_agent/source/calibration/plausibility.h"
#include "client_agent/source/lists/timeline.h"
#include "client_agent/source/source_finding.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

struct SourceDescription {
  std::string layout;        // Name for people: "KITTI odometry, grey".
  std::string camera_model;  // For people: "rectified stereo pair, pinhole".
  Intrinsics intrinsics;     // Intrinsics and size of the recorded (left) pictures.
  // Their size before they were scaled (?scale).
  std::optional<std::pair<int, int>> unscaled_px;
  std::string intrinsics_from;
  std::optional<double> baseline_m;         // Set for a stereo pair only.
  std::optional<double> depth_units_per_m;  // Set for an RGB-D camera only.
  std::string depth_units_from;
  std::string depth_registration;  // What is done to depth, for people. Empty: it is registered.
  double masked_percent = 0;       // Of the (first) picture, where the rig has a mask.
  std::string imu;       // How often and when its IMU measured, for people. Empty: it has none.
  bool is_live = false;  // A camera: how many frames there will be, and when, nobody knows.
  // Number of all frames of the sequence, selected or not.
  size_t frames = 0;
  TimeStatistics times;
  std::string times_from;
  SourceRemarks remarks;
};

// Returns a name and a value for each line, in the order in which people read them: "layout",
// "KITTI odometry".
std::vector<std::pair<std::string, std::string>> DescribeInLines(
    const SourceDescription& description);

// Returns intrinsics and size of the (left) pictures as they are recorded.
Intrinsics RecordedIntrinsics(const SensorCalibration& calibration);

// Fills in camera model, intrinsics and baseline or depth units, from the calibration.
void DescribeCamera(const SensorCalibration& calibration, SourceDescription& description);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_DESCRIPTION_H_

// What is known of a sequence before it is played, with where each part is known from.
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

namespace corbslam {

struct SourceDescription {
  std::string layout;        // "KITTI odometry, grey"
  std::string camera_model;  // "rectified stereo pair, pinhole"
  Intrinsics intrinsics;     // Of the (left) pictures as they are recorded, and their size.
  std::string intrinsics_from;
  std::optional<double> baseline_m;         // Stereo.
  std::optional<double> depth_units_per_m;  // RGB-D.
  std::string depth_units_from;
  // Of all frames of the sequence, selected or not.
  size_t frames = 0;
  TimeStatistics times;
  std::string times_from;
  SourceRemarks remarks;
};

// Name and value a line, in the order in which people read them: "layout", "KITTI odometry".
std::vector<std::pair<std::string, std::string>> DescribeInWords(
    const SourceDescription& description);

// Camera model, intrinsics and baseline or depth units, from the calibration.
void DescribeCamera(const SensorCalibration& calibration, SourceDescription& description);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_DESCRIPTION_H_

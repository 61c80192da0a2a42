// Writes the files of the public layouts as text: what the readers of client_agent/source read.
#ifndef CORBSLAM_SERVICES_TOOL_SEQUENCE_LAYOUT_FILES_H_
#define CORBSLAM_SERVICES_TOOL_SEQUENCE_LAYOUT_FILES_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "client_agent/source/source_spec.h"
#include "slam/evaluation/trajectory.h"
#include "slam/inertial/imu.h"
#include "slam/sensor/sensor.h"

namespace corbslam::services {

// Paths of a frame's two pictures below the folder: left and right, or grey and depth.
struct FramePaths {
  std::string first;
  std::string second;
};
FramePaths PathsOfFrame(client_agent::SourceLayout layout, size_t index, int64_t timestamp_ns);

// Makes the folders that the pictures go to. UNAVAILABLE if that fails.
absl::Status MakeLayoutFolders(client_agent::SourceLayout layout, const std::string& folder);

// Writes everything but the pictures: calibration, times, truth. The cameras must be the layout's:
// stereo for kKitti and kEuroc, RGB-D for kTum. Pairs that are not rectified have their lenses in
// EuRoC's sensor.yaml, which knows radial-tangential and equidistant ones; kKitti has no file for
// any. UNAVAILABLE if a file can't be written.
absl::Status WriteLayoutFiles(client_agent::SourceLayout layout, const std::string& folder,
                              const SensorCalibration& calibration, const Trajectory& truth);

// Writes mav0/imu0 of EuRoC's layout, whose body is the left camera. UNAVAILABLE if a file can't be
// written.
absl::Status WriteEurocImu(const std::string& folder, const ImuCalibration& imu,
                           const ImuSamples& samples);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_SEQUENCE_LAYOUT_FILES_H_

// Knows cameras whose calibration was published with their recordings, and which recordings these
// are.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_NAMED_CAMERAS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_NAMED_CAMERAS_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "slam/camera/distortion.h"

namespace corbslam::client_agent {

// An RGB-D camera of 640x480 pixels.
struct NamedCamera {
  absl::string_view name;  // For example "freiburg1".
  double fx_px, fy_px, cx_px, cy_px;
  RadialTangential distortion;
  double depth_units_per_m;
};
constexpr int kNamedCameraWidth_px = 640;
constexpr int kNamedCameraHeight_px = 480;

// Returns null where no camera is called so.
const NamedCamera* FindNamedCamera(absl::string_view name);
// Returns "freiburg1, freiburg2, ...".
std::string ListNamedCameras();

// Returns the camera of a recording of the TUM RGB-D benchmark, by the recording's exact name:
// "rgbd_dataset_freiburg2_desk". Returns null for every other name.
const NamedCamera* CameraOfTumRecording(absl::string_view recording);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_NAMED_CAMERAS_H_

// Reads the two forms of files that hold an RGB-D camera's calibration.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_RGBD_CALIBRATION_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_RGBD_CALIBRATION_FILE_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "slam/camera/distortion.h"

namespace corbslam::client_agent {

// What a file says; what it leaves out is absent.
struct RgbdCalibrationFile {
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  RadialTangential distortion;
  std::optional<double> depth_units_per_m;
  // Size in pixels of the pictures that the calibration is for.
  std::optional<double> width_px;
  std::optional<double> height_px;
};

// Reads YAML with fx, fy, cx, cy and what is optional (rgbd_calibration.h). Returns
// INVALID_ARGUMENT with file, line and field: one that is missing, unknown, there twice or no
// finite number.
absl::StatusOr<RgbdCalibrationFile> ReadRgbdYaml(const std::string& path);

// Reads ETH3D's form: one line with fx fy cx cy.
absl::StatusOr<RgbdCalibrationFile> ReadRgbdText(const std::string& path);

// Tells the form by the ending of the file's name: .txt is ETH3D's.
absl::StatusOr<RgbdCalibrationFile> ReadRgbdFile(const std::string& path);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_RGBD_CALIBRATION_FILE_H_

// Reads masks: pictures that are black (0) where nothing is to be looked at and white (255) where
// something is. What is neither is refused rather than taken for one of them.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_MASK_PICTURE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_MASK_PICTURE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// A mask that leaves out more of the picture is improbable, and may be inverted.
inline constexpr double kWideMask_percent = 60;

// Returns how much of the picture a mask, or a calibration's, leaves out; 0 of none.
double MaskedPercent(const PictureMask& mask);
double MaskedPercent(const SensorCalibration& calibration);

// Returns CV_8UC1 of 0 and 255 of an encoded picture; colour that is grey is taken.
// INVALID_ARGUMENT begins with `name` and says what to do: no picture or one that is cut short, 16
// bits, colours, an alpha channel, a grey in between, and a mask that leaves out more than 95 % of
// the picture.
absl::StatusOr<PictureMask> DecodeMaskPicture(absl::string_view name, const std::string& encoded);

// Does the same with a file. NOT_FOUND where there is none.
absl::StatusOr<PictureMask> ReadMaskPicture(const std::string& path);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_MASK_PICTURE_H_

// Reads masks that travel as PNG.
#ifndef CORBSLAM_SERVICES_AGENT_SERVICE_MASK_PNG_H_
#define CORBSLAM_SERVICES_AGENT_SERVICE_MASK_PNG_H_

#include <string>

#include "absl/status/statusor.h"
#include "slam/sensor/sensor.h"

namespace corbslam::services {

// Returns the mask of a PNG, empty for no bytes. INVALID_ARGUMENT for what is none, as
// DecodeMaskPicture says it; a mask that leaves out most of the picture is in the log. Its size is
// checked by who uses it (CheckMask).
absl::StatusOr<PictureMask> DecodeMask(const std::string& png);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_AGENT_SERVICE_MASK_PNG_H_

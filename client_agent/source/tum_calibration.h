// Calibrations of the TUM RGB-D recordings (Sturm et al., IROS 2012).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_TUM_CALIBRATION_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_TUM_CALIBRATION_H_

#include <string>

#include "absl/status/statusor.h"
#include "slam/sensor/sensor.h"

namespace corbslam {

// For pictures of the given size; see OpenTum for where the values come from.
absl::StatusOr<RgbdCalibration> ReadTumCalibration(const std::string& directory, int width_px,
                                                   int height_px);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_TUM_CALIBRATION_H_

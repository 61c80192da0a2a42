// Does what opening an RGB-D recording has in common, whatever its layout.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RGBD_OPENING_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RGBD_OPENING_H_

#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/calibration/rgbd_calibration.h"
#include "client_agent/source/listed_reader.h"

namespace corbslam::client_agent {

// Makes the query of the options and the first picture that can be read. Errors name the picture.
absl::StatusOr<RgbdCalibrationQuery> MakeCalibrationQuery(const SourceSpec& spec,
                                                          const std::vector<ListedFrame>& frames);

// Puts the calibration, and where it is from, into `sequence`.
void TakeCalibration(FoundRgbdCalibration found, ListedSequence& sequence);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RGBD_OPENING_H_

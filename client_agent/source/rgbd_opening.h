// Does what opening an RGB-D recording has in common, whatever its layout.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RGBD_OPENING_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RGBD_OPENING_H_

#include "absl/status/status.h"
#include "client_agent/source/listed_reader.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {

// Puts the recording's calibration, and where it is from, into `sequence`, whose frames are listed:
// from ?rig, or as FindRgbdCalibration finds it. Errors name the file or the picture.
absl::Status CalibrateRgbd(const SourceSpec& spec, ListedSequence& sequence);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RGBD_OPENING_H_

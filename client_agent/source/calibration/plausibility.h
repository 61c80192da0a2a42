// Judges whether a calibration can be of the pictures that it is said to be of.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_PLAUSIBILITY_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_PLAUSIBILITY_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/calibration/stated_imu.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

// Pinhole intrinsics in pixels and the size of the pictures they are for.
struct Intrinsics {
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  int width_px = 0;
  int height_px = 0;
};

// Finds what is improbable: a principal point off the middle, an odd focal length. What no camera
// has is INVALID_ARGUMENT: a principal point outside the middle of the picture, as where pictures
// have half or twice the size, a focal length of the wrong order. `from` names the calibration's
// file or option. With `trust` (?trust-calibration) everything finite is taken, and a finding says
// so.
absl::StatusOr<SourceFindings> CheckIntrinsics(const Intrinsics& intrinsics, absl::string_view from,
                                               bool trust);

// Does the same for the distance between the cameras of a stereo pair.
absl::StatusOr<SourceFindings> CheckBaseline(double baseline_m, absl::string_view from, bool trust);

// Does the same for an IMU's rate and noise, where they are stated.
absl::StatusOr<SourceFindings> CheckImuNumbers(const StatedImu& imu, absl::string_view from,
                                               bool trust);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_PLAUSIBILITY_H_

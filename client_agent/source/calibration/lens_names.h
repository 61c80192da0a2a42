// Makes a lens of what calibration files call it and of its numbers.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_LENS_NAMES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_LENS_NAMES_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/camera/lens.h"

namespace corbslam::client_agent {

// Returns the lens that is called `name` by any of the calibration tools that are known (Kalibr's
// radtan, equidistant, ROS's plumb_bob, rational_polynomial, fisheye, OpenCV's and our own names;
// none), with `numbers` in the order in which all of them write them:
//
//   radial-tangential: none, k1 k2 p1 p2, with k3, or with k3 k4 k5 k6 (further ones must be 0)
//   equidistant:       k1 k2 k3 k4
//   double-sphere:     xi alpha
//   unified:           xi, then those of radial-tangential
//
// INVALID_ARGUMENT says the name or the count, and what is known.
absl::StatusOr<LensModel> LensOfName(absl::string_view name, const std::vector<double>& numbers);

// Returns the numbers of a lens in the same order; LensOfName of NameOf(lens) and these is `lens`.
std::vector<double> NumbersOf(const LensModel& lens);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CALIBRATION_LENS_NAMES_H_

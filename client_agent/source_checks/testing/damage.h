// Makes sources with something wrong of good ones, for tests and measurements.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_DAMAGE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_DAMAGE_H_

#include <cstddef>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source_checks/sample.h"

namespace corbslam::client_agent {

using ReadFrame = std::function<absl::StatusOr<SensorImages>(size_t)>;

// `name` with `amount`: of a pair "exchanged", "same" (the left picture twice), "rows" (the right
// picture lies lower, pixels), "columns" (farther right), "roll" (degrees), "mirrored", "late" (the
// right picture is that of so many frames before); of both "dark" (grey levels divided), "bright"
// (multiplied), "noise"; of depth "depth_scale" (multiplied), "depth_saturated" (65535 where there
// is none), "depth_late", "depth_shift" (columns), "depth_empty", "depth_constant". "" changes
// nothing. INVALID_ARGUMENT for another name, when a frame is read.
ReadFrame Damage(ReadFrame read, const std::string& name, double amount = 0);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_DAMAGE_H_

// Says which settings of robots no robot could run with.
#ifndef CORBSLAM_SERVICES_CONVERT_ROBOT_SETTINGS_CHECK_H_
#define CORBSLAM_SERVICES_CONVERT_ROBOT_SETTINGS_CHECK_H_

#include <cstdint>

#include "absl/status/status.h"
#include "corbslam/v1/robot_settings.pb.h"

namespace corbslam::services {

// No robot keeps to less, whatever its camera is (docs/robot.md): one of the smallest pictures and
// the fewest features, with a map of a few keyframes.
inline constexpr uint64_t kLeastMemoryBudget_bytes = uint64_t{98} << 20;
// More has no computer: a negative number is read as one of 2^64 less it.
inline constexpr uint64_t kMostMemoryBudget_bytes = uint64_t{1} << 50;

// INVALID_ARGUMENT names the first field that is out of its bounds, its value and its bounds, or
// two fields that no robot can follow together. Who signs settings, who stores them and who runs
// with them asks the same; what a robot's own camera and flags allow is its own to say.
absl::Status CheckRobotSettings(const v1::RobotSettings& settings);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_ROBOT_SETTINGS_CHECK_H_

// The error for a mission that is not in memory at this moment, and can be had a moment later.
#ifndef CORBSLAM_MAP_STORE_VIEW_ASLEEP_ERROR_H_
#define CORBSLAM_MAP_STORE_VIEW_ASLEEP_ERROR_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::map_store {

// Returns UNAVAILABLE, which remembers the mission's name.
absl::Status AsleepError(absl::string_view mission);

// Returns the name of the mission if the error is one of AsleepError's.
std::optional<std::string> AsleepMission(const absl::Status& status);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_ASLEEP_ERROR_H_

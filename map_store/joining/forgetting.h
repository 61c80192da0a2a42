// Deletes old sessions of a robot: its local maps, with all that stands in them.
#ifndef CORBSLAM_MAP_STORE_JOINING_FORGETTING_H_
#define CORBSLAM_MAP_STORE_JOINING_FORGETTING_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Of an agent's closed local maps. One of the two limits is set.
struct ForgetRequest {
  std::string agent;
  // Those whose newest frame or keyframe is older, by the agent's own clock in nanoseconds.
  std::optional<int64_t> before_ns;
  // All but the newest ones.
  std::optional<size_t> keep;
  bool dry_run = false;
};

struct ForgottenLocalMaps {
  std::vector<LocalMapId> local_maps;  // In the order of their arrival.
  // Which of the agent's local maps go (ArrivalBook), those that had become parts of others
  // included; ascending.
  std::vector<uint64_t> numbers;
  uint64_t keyframes = 0;
  uint64_t map_points = 0;
  uint64_t stored_bytes = 0;
  // How many of them had become parts of others before, and go with these.
  uint64_t parts = 0;
};

// Returns what the request is of. A local map whose parts are of several ages goes when its newest
// part is old enough. Open local maps stay. Returns NOT_FOUND if there is no such agent, and
// INVALID_ARGUMENT unless one limit is set.
absl::StatusOr<ForgottenLocalMaps> ChooseForgotten(const ForgetRequest& request,
                                                   const MissionState& state);

// Returns DATA_LOSS where one of them is unknown, open or named twice.
absl::Status CheckForgetting(const std::vector<LocalMapId>& local_maps, const MissionState& state);

// Takes the local maps out of the mission. What others saw of their points is not seen any more
// unless it is a landmark of theirs, too; overlaps with them are forgotten. Where others stand does
// not change. Their ids never come back. Costs as much as they have items.
void ForgetLocalMaps(const std::vector<LocalMapId>& local_maps, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_JOINING_FORGETTING_H_

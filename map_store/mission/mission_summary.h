// What a store knows of a mission that is asleep: its answers to those who only list missions.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_SUMMARY_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_SUMMARY_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "map_store/mission/mission_load.h"
#include "map_store/state/lookups.h"

namespace corbslam::map_store {

// A mission as it fell asleep. What the store says of all missions (workers, damage) is not in it.
struct MissionSummary {
  MissionInfo info;
  MissionLoad load;
  // Whether fusion would have something to do, had it a worker.
  bool work_left = false;
  // Whether all that may retire had: when the mission wakes, only what comes then is looked at.
  bool retired = false;
};

// Returns the bytes of all that is the mission's own; they begin with the number of their format.
std::string EncodeSummary(const MissionSummary& summary);
// Returns DATA_LOSS for bytes that are no summary, or one of another format.
absl::StatusOr<MissionSummary> DecodeSummary(absl::string_view bytes);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_SUMMARY_H_

// Copies what records don't say of a mission: what was decided without a worker, and what is
// counted. It is small; a snapshot has it from the mission as it stands and all the rest from the
// journal.
#ifndef CORBSLAM_MAP_STORE_RECORDS_UNRECORDED_STATE_H_
#define CORBSLAM_MAP_STORE_RECORDS_UNRECORDED_STATE_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

struct UnrecordedState {
  std::map<std::string, std::vector<LocalMapId>> agents;
  QueryQueue queries;
  OverlapLedger overlaps;
  std::map<IslandId, Island> islands;
  uint64_t version = 0;
  MissionStatistics statistics;
};

UnrecordedState CopyUnrecorded(const MissionState& state);
// Puts it into a state of the same mission at the same record.
void PutUnrecorded(UnrecordedState unrecorded, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_UNRECORDED_STATE_H_

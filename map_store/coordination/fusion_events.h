// Says what fusion's records did, for those who are told of events.
#ifndef CORBSLAM_MAP_STORE_COORDINATION_FUSION_EVENTS_H_
#define CORBSLAM_MAP_STORE_COORDINATION_FUSION_EVENTS_H_

#include <cstdint>
#include <vector>

#include "absl/time/time.h"
#include "map_store/records/journal_records.h"
#include "map_store/state/mission_event.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns those of the overlaps with this id and newer ones that were accepted.
std::vector<MissionEvent::OverlapAccepted> ListAcceptedFrom(uint64_t first,
                                                            const MissionState& state);
// Returns what the record, which was just applied, has joined: islands, or an island with itself.
MissionEvent::What DescribeFusing(const FuseRecord& record, const MissionState& state);
// `took` is the time since the adjustment's snapshot.
MissionEvent::MapAdjusted DescribeAdjustment(const AdjustRecord& record, absl::Duration took);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_COORDINATION_FUSION_EVENTS_H_

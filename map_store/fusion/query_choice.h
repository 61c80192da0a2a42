// Chooses which local maps are queried for the place of a keyframe.
#ifndef CORBSLAM_MAP_STORE_FUSION_QUERY_CHOICE_H_
#define CORBSLAM_MAP_STORE_FUSION_QUERY_CHOICE_H_

#include <vector>

#include "absl/status/statusor.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/long_read.h"

namespace corbslam::map_store {

// Returns the local map whose first waiting keyframe makes the next query: those that nothing is
// joined with come before the others, of both kinds the ones whose robots drive come before closed
// ones, and of these the one that has waited longest. So a robot that nobody knows yet is not kept
// waiting by known ground. Invalid: nothing waits.
LocalMapId ChooseNextToQuery(const MissionState& state);

// Returns, of the local maps that the queue's first keyframe has still to query, those
// that are worth a worker's time, in the queue's order: the two that hold what looks most like it;
// the one of an island it is not joined with that does, if those two are of its own; and the one
// that ended where its own local map begins. Of a place that is linked to two others of its
// island already, other islands alone are left, and its own local map if that looks like it as
// these do. So a keyframe costs at most
// four queries, however many local maps there are (docs/adr/0038-look-ups-by-keyframe.md). Of an
// empty queue there are none: a mission that is deleted meanwhile has one. ABORTED: as `read` says.
absl::StatusOr<std::vector<LocalMapId>> ChooseQueriedMaps(const MissionState& state,
                                                          const MapStoreOptions& options,
                                                          LongRead& read);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_QUERY_CHOICE_H_

// Makes one update for one agent from what it was sent and what is there now.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARE_STEP_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARE_STEP_H_

#include <cstddef>

#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "map_store/view/long_read.h"
#include "slam/exchange/shared_update.h"

namespace corbslam::map_store {

// Returns an update of the agent's island, which has more than one local map, and notes it in
// `share` as sent. It costs as much as changed since the last complete update, and more only after
// fusion moved everything. `read` pauses meanwhile; if a pause returns an error, or the revision is
// another after it, the update ends there, and may be empty.
SharedUpdate TakeShareStep(const MissionState& state, const Island& island,
                           const MapStoreOptions& options, size_t byte_budget, ShareState& share,
                           LongRead& read);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARE_STEP_H_

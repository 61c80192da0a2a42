// One update for one agent: what it was sent against what is there now.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARE_STEP_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARE_STEP_H_

#include <cstddef>

#include "map_store/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "map_store/view/long_read.h"
#include "slam/exchange/shared_update.h"

namespace corbslam::map_store {

// Of the agent's island, which has more than one local map; noted in `share` as sent. Costs as much
// as changed since the last complete one, and more only after fusion moved everything. `read`
// pauses meanwhile; the update ends, and may be empty, where one of its errors or another revision
// says so.
SharedUpdate TakeShareStep(const MissionState& state, const Island& island,
                           const MapStoreOptions& options, size_t byte_budget, ShareState& share,
                           LongRead& read);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARE_STEP_H_

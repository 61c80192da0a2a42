// Is a whole mission that comes from outside fit to be served? Its parts fit together
// (state_validation.h); this is about what they say.
#ifndef CORBSLAM_MAP_STORE_RECORDS_RESTORED_STATE_H_
#define CORBSLAM_MAP_STORE_RECORDS_RESTORED_STATE_H_

#include "absl/status/status.h"
#include "map_store/options.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// What ValidateBatch asks of batches, of all that they have made. Errors are as there. References
// are sound already: DecodeState looks at them.
absl::Status ValidateRestored(const MissionState& state, const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_RESTORED_STATE_H_

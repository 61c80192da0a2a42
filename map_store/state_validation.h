// Is a whole mission that comes from outside fit to be served?
#ifndef CORBSLAM_MAP_STORE_STATE_VALIDATION_H_
#define CORBSLAM_MAP_STORE_STATE_VALIDATION_H_

#include "absl/status/status.h"
#include "map_store/mission_state.h"
#include "map_store/options.h"

namespace corbslam::map_store {

// What ValidateBatch asks of batches, of all that they have made. Errors are as there. References
// are sound already: DecodeState looks at them.
absl::Status ValidateState(const MissionState& state, const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_VALIDATION_H_

// Checks whether a whole mission that comes from outside is fit to be served. Whether its parts fit
// together is for state_validation.h; this is about what they say.
#ifndef CORBSLAM_MAP_STORE_RECORDS_RESTORED_STATE_H_
#define CORBSLAM_MAP_STORE_RECORDS_RESTORED_STATE_H_

#include "absl/status/status.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Asks of all that a mission's batches have made what ValidateBatch asks of batches, with the same
// errors. References are sound already: DecodeState looks at them.
absl::Status ValidateRestored(const MissionState& state, const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_RESTORED_STATE_H_

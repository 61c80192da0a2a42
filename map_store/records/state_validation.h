// Is a state that was read back whole? A store takes for granted that what its state refers to is
// there; bytes from a disk don't.
#ifndef CORBSLAM_MAP_STORE_RECORDS_STATE_VALIDATION_H_
#define CORBSLAM_MAP_STORE_RECORDS_STATE_VALIDATION_H_

#include "absl/status/status.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Between the parts of the state; each item's values were looked at when it was read. DATA_LOSS
// says which part disagrees with which.
absl::Status ValidateState(const MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_STATE_VALIDATION_H_

// Checks whether a state that was read back is whole: a store takes for granted that what its state
// refers to is there, but bytes from a disk need not be so.
#ifndef CORBSLAM_MAP_STORE_RECORDS_STATE_VALIDATION_H_
#define CORBSLAM_MAP_STORE_RECORDS_STATE_VALIDATION_H_

#include "absl/status/status.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Checks the parts of the state against one another; each item's values were looked at when it was
// read. DATA_LOSS says which part disagrees with which.
absl::Status ValidateState(const MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_STATE_VALIDATION_H_

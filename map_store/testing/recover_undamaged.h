// Has a store take in its journal, for tests to which damage is a failure.
#ifndef CORBSLAM_MAP_STORE_TESTING_RECOVER_UNDAMAGED_H_
#define CORBSLAM_MAP_STORE_TESTING_RECOVER_UNDAMAGED_H_

#include "absl/status/status.h"
#include "map_store/store/map_store.h"
#include "slam/util/status_macros.h"

namespace corbslam::testing {

// Returns DATA_LOSS if a mission could not be read.
inline absl::Status RecoverUndamaged(map_store::MapStore& store) {
  RETURN_IF_ERROR(store.Recover());
  for (const auto& [name, damage] : store.ListDamaged()) return absl::DataLossError(damage);
  return absl::OkStatus();
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_RECOVER_UNDAMAGED_H_

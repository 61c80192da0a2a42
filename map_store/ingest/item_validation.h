// Checks that one keyframe is within what the store takes. The robot makes the other checks of
// single items, too: slam/exchange/item_checks.h.
#ifndef CORBSLAM_MAP_STORE_INGEST_ITEM_VALIDATION_H_
#define CORBSLAM_MAP_STORE_INGEST_ITEM_VALIDATION_H_

#include "absl/status/status.h"
#include "map_store/options/options.h"
#include "slam/exchange/item_checks.h"
#include "slam/exchange/map_update.h"

namespace corbslam::map_store {

// Checks the same as the function of this name in slam/exchange, and returns RESOURCE_EXHAUSTED if
// the keyframe has more keypoints or bytes than `options` allow.
absl::Status ValidateFullKeyframe(const FullKeyframe& keyframe, const Camera& camera,
                                  const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_ITEM_VALIDATION_H_

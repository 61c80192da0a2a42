// Is one keyframe within what the store takes? The other checks of single items are the robot's,
// too: slam/exchange/item_checks.h.
#ifndef CORBSLAM_MAP_STORE_INGEST_ITEM_VALIDATION_H_
#define CORBSLAM_MAP_STORE_INGEST_ITEM_VALIDATION_H_

#include "absl/status/status.h"
#include "map_store/options.h"
#include "slam/exchange/item_checks.h"
#include "slam/exchange/map_update.h"

namespace corbslam::map_store {

// As the check of the same name in slam/exchange; RESOURCE_EXHAUSTED where the keyframe has more
// keypoints or bytes than `options` allow.
absl::Status ValidateFullKeyframe(const FullKeyframe& keyframe, const Camera& camera,
                                  const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_ITEM_VALIDATION_H_

#include "map_store/ingest/item_validation.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/quota.h"

namespace corbslam::map_store {

absl::Status ValidateFullKeyframe(const FullKeyframe& keyframe, const Camera& camera,
                                  const MapStoreOptions& options) {
  const KeyframePayload& payload = *keyframe.payload;
  const size_t count = payload.features.keypoints.size();
  if (count > options.max_keypoints_per_keyframe) {
    return absl::ResourceExhaustedError(absl::StrCat("full keyframe ", ToString(payload.id),
                                                     " has ", count, " keypoints; the limit is ",
                                                     options.max_keypoints_per_keyframe));
  }
  if (PayloadBytes(payload) > options.max_keyframe_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("full keyframe ", ToString(payload.id), " has ", PayloadBytes(payload),
                     " bytes; the limit is ", options.max_keyframe_bytes));
  }
  return corbslam::ValidateFullKeyframe(keyframe, camera);
}

}  // namespace corbslam::map_store

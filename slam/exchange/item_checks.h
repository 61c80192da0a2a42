// Are the values of one item of a MapUpdateBatch possible? Asked by the robot before it tells an
// item, and by the map store before it takes one. Each error is INVALID_ARGUMENT and names the
// item, the field, its value and its limits.
#ifndef CORBSLAM_SLAM_EXCHANGE_ITEM_CHECKS_H_
#define CORBSLAM_SLAM_EXCHANGE_ITEM_CHECKS_H_

#include <cstdint>
#include <set>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "slam/exchange/map_update.h"

namespace corbslam {

// Checks that the id is valid.
template <typename Id>
absl::Status ValidateAny(absl::string_view what, Id id) {
  if (id.IsValid()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(what, ": no id"));
}

// Checks that it is of the batch's own local map, too; else PERMISSION_DENIED.
template <typename Id>
absl::Status ValidateOwn(absl::string_view what, Id id, LocalMapId own) {
  if (!id.IsValid()) return ValidateAny(what, id);
  if (id.local_map == own) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat(what, " ", ToString(id), " is not of the batch's local map ", ToString(own)));
}

// Checks that it is not in `seen`, which learns it.
template <typename Id>
absl::Status ValidateOnce(absl::string_view what, Id id, std::set<Id>& seen) {
  if (seen.insert(id).second) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(what, " ", ToString(id), " comes twice"));
}

// Times are 0 to 2^62 ns.
absl::Status ValidateTime(absl::string_view what, int64_t time_ns);
absl::Status ValidatePosition(absl::string_view what, MapPointId id, absl::string_view field,
                              const Eigen::Vector3d& position);
absl::Status ValidatePose(absl::string_view what, KeyframeId id, absl::string_view field,
                          const Rigid3d& pose);
absl::Status ValidateSimilarity(absl::string_view what, KeyframeId id,
                                const Similarity3d& similarity);

// `camera` is the one that the payload's index names. The payload must not be null.
absl::Status ValidateFullKeyframe(const FullKeyframe& keyframe, const Camera& camera);
absl::Status ValidateLightKeyframe(const LightKeyframe& keyframe);
absl::Status ValidateRemoval(const KeyframeRemoval& removal);
absl::Status ValidateFullPoint(const FullMapPoint& point);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_ITEM_CHECKS_H_

// Knows which map points follow a keyframe when it moves (MapUpdateBatch::points_follow).
#ifndef CORBSLAM_SLAM_EXCHANGE_POINT_FOLLOWERS_H_
#define CORBSLAM_SLAM_EXCHANGE_POINT_FOLLOWERS_H_

#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "slam/util/ids.h"

namespace corbslam {

// Points are added here and not taken out when they leave the map: a caller's predicate says which
// of them are gone, and these are then forgotten. Not thread-safe.
class PointFollowers {
 public:
  void Add(KeyframeId reference, MapPointId point) { points_[reference].push_back(point); }
  void Forget(KeyframeId reference) { points_.erase(reference); }

  // Returns the keyframe's points for which `follows` holds, in the order in which they were added.
  template <typename Predicate>
  const std::vector<MapPointId>& Of(KeyframeId reference, Predicate&& follows) {
    static const std::vector<MapPointId>& kNone = *new std::vector<MapPointId>();
    const auto it = points_.find(reference);
    if (it == points_.end()) return kNone;
    std::erase_if(it->second, [&follows](MapPointId point) { return !follows(point); });
    return it->second;
  }

 private:
  absl::flat_hash_map<KeyframeId, std::vector<MapPointId>> points_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_POINT_FOLLOWERS_H_

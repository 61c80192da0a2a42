// How often tracking expected to see the newest map points, and how often it did: what the mapper
// culls by. Kept beside the map, because it is nobody else's business.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_POINT_STATISTICS_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_POINT_STATISTICS_H_

#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/synchronization/mutex.h"
#include "slam/util/ids.h"

namespace corbslam {

// Thread-safe. Only watched points are counted.
class PointStatistics {
 public:
  // Starts counting, at one of each: the keyframe that made the point sees it.
  void Watch(MapPointId id);
  void Forget(MapPointId id);

  // One frame: points that should have been in view, and those of them that agreed with the pose.
  void Count(const std::vector<MapPointId>& visible, const std::vector<MapPointId>& found);

  // Found over visible; 1 for points not watched.
  double FoundRatio(MapPointId id) const;

 private:
  struct Counts {
    int visible = 1;
    int found = 1;
  };
  mutable absl::Mutex mutex_;
  absl::flat_hash_map<MapPointId, Counts> counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_POINT_STATISTICS_H_

// Counts how often tracking expected to see the newest map points, and how often it did. The mapper
// culls by it. It is kept beside the map, because nobody else needs it.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_POINT_STATISTICS_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_POINT_STATISTICS_H_

#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/synchronization/mutex.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// Only watched points are counted. Thread-safe.
class PointStatistics {
 public:
  // Starts counting, with both counts at one: the keyframe that made the point sees it.
  void Watch(MapPointId id);
  void Forget(MapPointId id);

  // Counts one frame: points that should have been in view, and those of them that agreed with the
  // pose.
  void Count(const std::vector<MapPointId>& visible, const std::vector<MapPointId>& found);

  // Returns found over visible; 1 for points that are not watched.
  double FoundRatio(MapPointId id) const;

 private:
  struct Counts {
    int visible = 1;
    int found = 1;
  };
  mutable absl::Mutex mutex_;
  absl::flat_hash_map<MapPointId, Counts> counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_POINT_STATISTICS_H_

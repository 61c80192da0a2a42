// Remembers which points were met already, for hundreds of thousands of questions a second.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_POINT_SET_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_POINT_SET_H_

#include <vector>

#include "absl/container/flat_hash_set.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// The own map's points are numbered without large gaps, so each takes a bit. Nobody knows how
// others' points are numbered, so they are hashed.
class PointSet {
 public:
  explicit PointSet(LocalMapId own) : own_(own) {}

  // Returns false if it is there already.
  bool Insert(MapPointId id) {
    if (id.local_map != own_) return others_.insert(id).second;
    if (id.index >= own_points_.size()) own_points_.resize(size_t{id.index} + 1);
    const bool is_new = !own_points_[id.index];
    own_points_[id.index] = true;
    return is_new;
  }

 private:
  const LocalMapId own_;
  std::vector<bool> own_points_;
  absl::flat_hash_set<MapPointId> others_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_POINT_SET_H_

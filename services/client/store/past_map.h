// The map of a mission at a moment of its past, with all its islands, as ReplayMap tells it.
#ifndef CORBSLAM_SERVICES_CLIENT_STORE_PAST_MAP_H_
#define CORBSLAM_SERVICES_CLIENT_STORE_PAST_MAP_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "services/convert/ids.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// A value; not thread-safe.
class PastMap {
 public:
  struct Keyframe {
    KeyframeId parent;  // Invalid if it has none.
    Rigid3d island_from_camera;
  };
  struct Island {
    bool in_global_frame = false;
    std::map<KeyframeId, Keyframe> keyframes;
    std::map<MapPointId, Eigen::Vector3d> points;
  };

  // Takes in one message. INVALID_ARGUMENT names what can't be read; the map is void then.
  absl::Status Apply(const v1::WatchMapResponse& changes);

  uint64_t revision() const { return revision_; }
  // By the local map that names each.
  const std::map<LocalMapId, Island>& islands() const { return islands_; }
  // Returns the agent of a local map; an empty name if that was not told.
  std::string AgentOf(LocalMapId local_map) const;

 private:
  absl::Status ApplyIsland(const v1::WatchMapResponse::Island& changes, const SlotReader& slots);

  uint64_t revision_ = 0;
  std::map<LocalMapId, std::string> agents_;
  std::map<LocalMapId, Island> islands_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_STORE_PAST_MAP_H_

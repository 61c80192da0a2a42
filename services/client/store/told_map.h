// Keeps a mission's whole map, all islands of it, as the responses of WatchMap and ReplayMap tell
// it.
#ifndef CORBSLAM_SERVICES_CLIENT_STORE_TOLD_MAP_H_
#define CORBSLAM_SERVICES_CLIENT_STORE_TOLD_MAP_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "absl/container/btree_map.h"
#include "absl/status/status.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "services/convert/ids.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// A value; not thread-safe.
struct ToldMap {
  struct Keyframe {
    Rigid3d island_from_camera;
    KeyframeId parent;  // Invalid if it has none.
  };
  struct Island {
    bool in_global_frame = false;
    absl::btree_map<KeyframeId, Keyframe> keyframes;
    absl::btree_map<MapPointId, Eigen::Vector3f> points;
  };
  // Islands by the local map that names them.
  using Islands = std::map<LocalMapId, Island>;

  // INVALID_ARGUMENT names what can't be read; what came before it in the message is applied.
  absl::Status Apply(const v1::WatchMapResponse& changes);

  // Returns who made the local map; "" if that is not known.
  std::string AgentOf(LocalMapId local_map) const;
  size_t CountKeyframes() const;

  uint64_t version = 0;
  uint64_t revision = 0;
  Islands islands;
  std::map<LocalMapId, std::string> agents;

 private:
  absl::Status ApplyIsland(const v1::WatchMapResponse::Island& changes, const SlotReader& slots);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_STORE_TOLD_MAP_H_

// Copies the part of a local map around a place, for programs that plan.
#ifndef CORBSLAM_CLIENT_AGENT_MAP_NEAR_MAP_H_
#define CORBSLAM_CLIENT_AGENT_MAP_NEAR_MAP_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "client_agent/map/guarded_map.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

struct NearMapLimits {
  double radius_m = 20;
  // The nearest are kept.
  size_t max_points = 10'000;
  size_t max_keyframes = 5'000;
};

// All is in the local map's frame, the nearest first.
struct NearMap {
  LocalMapId local_map;
  int64_t timestamp_ns = 0;  // Of the frame around whose camera it lies.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3f> own_points;
  std::vector<Eigen::Vector3f> shared_points;  // Those that others made.
  struct NearKeyframe {
    KeyframeId id;
    Rigid3d local_from_camera;
    bool shared = false;
  };
  std::vector<NearKeyframe> keyframes;
  // More lies within the radius.
  bool truncated = false;
};

// Returns what of the map lies within the radius around `centre`. It reads the map in pieces, so
// that nobody waits for long; if the map was moved as a whole meanwhile, it begins again. Costs a
// look at every point and keyframe of the map. Thread-safe.
NearMap FindNearMap(const GuardedMap& map, const Eigen::Vector3d& centre,
                    const NearMapLimits& limits);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAP_NEAR_MAP_H_

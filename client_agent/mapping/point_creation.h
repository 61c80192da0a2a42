// Makes new points from pairs of views.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_POINT_CREATION_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_POINT_CREATION_H_

#include <optional>
#include <vector>

#include "client_agent/map/guarded_map.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// Locates the point that keypoint `index_a` of `a` and `index_b` of `b` see: from the two rays, or
// from the depth of one of them where that says more than their parallax. Returns none where
// neither says enough, or the point does not fit both pixels and octaves (ORB-SLAM2, T-RO 2017, and
// ORB-SLAM, T-RO 2015, VI.C).
std::optional<Eigen::Vector3d> LocatePoint(const Keyframe& a, uint32_t index_a, const Keyframe& b,
                                           uint32_t index_b);

// Makes points of the keyframe and its ten most covisible neighbours that are not in the map yet;
// returns the new ones. Mapping thread only; writes.
std::vector<MapPointId> CreatePoints(KeyframeId keyframe, GuardedMap& map);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_POINT_CREATION_H_

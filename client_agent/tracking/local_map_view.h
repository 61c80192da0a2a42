// The part of the map that a frame may see: its local map, in the sense of ORB-SLAM.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_LOCAL_MAP_VIEW_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_LOCAL_MAP_VIEW_H_

#include <vector>

#include "slam/map/map.h"
#include "slam/matching/match_point.h"

namespace corbslam::client_agent {

struct PointInView {
  MatchPoint point;
  PredictedView view;
};

struct LocalMapView {
  // Points of all robots, as far as the frame's pose has them in view.
  std::vector<PointInView> points;
  // The own keyframe that shares most points with the frame; invalid when there is none.
  KeyframeId reference;
  Rigid3d reference_from_map;
  // Points of the reference that enough keyframes see (an observation with depth counts twice).
  int reference_points = 0;
  // Share of the points seen by the frame already that the reference sees, too.
  double share_of_reference = 0;
  int map_keyframes = 0;
};

// Gathers the local map of a frame that sees the points `seen` already. Its keyframes are those
// that see these points, and for each of them one neighbour, the children and the parent, 80 in all
// (ORB-SLAM, T-RO 2015, V.D). When no keyframe sees them, they are `fallback` and its neighbours.
LocalMapView GatherLocalMap(const Map& map, LocalMapId own, const std::vector<MapPointId>& seen,
                            KeyframeId fallback, const Camera& camera,
                            const Rigid3d& camera_from_map);

// Makes the keyframe the reference that shares most of the points `seen`, whoever made it.
void ReferToOthers(const Map& map, const std::vector<MapPointId>& seen, LocalMapView& view);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_LOCAL_MAP_VIEW_H_

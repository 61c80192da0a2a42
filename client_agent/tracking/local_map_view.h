// The part of the map that a frame may see: its local map, in the sense of ORB-SLAM.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_LOCAL_MAP_VIEW_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_LOCAL_MAP_VIEW_H_

#include <vector>

#include "slam/map/map.h"
#include "slam/matching/match_point.h"

namespace corbslam {

struct PointInView {
  MatchPoint point;
  PredictedView view;
};

struct LocalMapView {
  // Everybody's, as far as the frame's pose has them in view.
  std::vector<PointInView> points;
  // The own keyframe that shares most points with the frame; invalid when there is none.
  KeyframeId reference;
  Rigid3d reference_from_map;
  // Points of the reference that enough keyframes see (an observation with depth counts twice).
  int reference_points = 0;
  // Of the points that the frame sees already, the share that the reference sees.
  double share_of_reference = 0;
  int map_keyframes = 0;
};

// `seen` are the points that the frame sees already. Its keyframes: those that see these points,
// and for each of them one neighbour, the children and the parent, 80 in all (ORB-SLAM, T-RO 2015,
// V.D). When nobody sees them, `fallback` and its neighbours.
LocalMapView GatherLocalMap(const Map& map, LocalMapId own, const std::vector<MapPointId>& seen,
                            KeyframeId fallback, const Camera& camera,
                            const Rigid3d& camera_from_map);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_LOCAL_MAP_VIEW_H_

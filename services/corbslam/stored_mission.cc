#include "services/corbslam/stored_mission.h"

#include <set>

namespace corbslam {

Trajectory ToTrajectory(const StoredTrajectory& stored) {
  Trajectory trajectory;
  for (const StoredPose& pose : stored) {
    trajectory.push_back({pose.timestamp_ns, pose.frame_from_camera});
  }
  SortByTime(trajectory);
  return trajectory;
}

size_t CountLocalMaps(const StoredTrajectory& stored) {
  std::set<std::string> local_maps;
  for (const StoredPose& pose : stored) local_maps.insert(pose.local_map);
  return local_maps.size();
}

}  // namespace corbslam

#include "services/client/store/served_mission.h"

#include <set>

namespace corbslam::services {

Trajectory ToTrajectory(const ServedTrajectory& stored) {
  Trajectory trajectory;
  for (const ServedPose& pose : stored) {
    trajectory.push_back({pose.timestamp_ns, pose.frame_from_camera});
  }
  SortByTime(trajectory);
  return trajectory;
}

size_t CountLocalMaps(const ServedTrajectory& stored) {
  std::set<std::string> local_maps;
  for (const ServedPose& pose : stored) local_maps.insert(pose.local_map);
  return local_maps.size();
}

}  // namespace corbslam::services

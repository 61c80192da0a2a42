#include "services/client/store/served_mission.h"

#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace corbslam::services {

std::string NameOfRun(uint64_t run) {
  return absl::StrCat("localised-", absl::Hex(run, absl::kZeroPad16));
}

std::string Describe(const UnposedFrames& unposed) {
  return absl::StrCat(unposed.lost, " frames were lost, ", unposed.left_out,
                      " lie elsewhere or nowhere any more, ", unposed.dropped, " are kept no more");
}

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

std::string Describe(const ServedMap::Elsewhere& elsewhere) {
  return absl::StrJoin(elsewhere.keyframes, ", ", [](std::string* text, const auto& robot) {
    const auto& [agent, keyframes] = robot;
    absl::StrAppend(text, agent.empty() ? "?" : agent, " (", keyframes,
                    keyframes == 1 ? " keyframe)" : " keyframes)");
  });
}

}  // namespace corbslam::services

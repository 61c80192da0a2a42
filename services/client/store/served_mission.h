// Holds a mission as a map store serves it, read once and kept: for reports, trajectories and
// pictures.
#ifndef CORBSLAM_SERVICES_CLIENT_STORE_SERVED_MISSION_H_
#define CORBSLAM_SERVICES_CLIENT_STORE_SERVED_MISSION_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "slam/evaluation/trajectory.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::services {

struct ServedPose {
  int64_t timestamp_ns = 0;
  // The frame is that of `local_map` in a local trajectory, that of `island` in a global one.
  Rigid3d frame_from_camera;
  std::string local_map;    // Name of the local map's resource, or NameOfRun.
  std::string island = {};  // Likewise, of the local map that names the island.
  bool after_gap = false;   // Nothing connects it with the pose before.
};

// Holds every tracked frame of one agent, by local map, in time. A global trajectory leaves out
// local maps that are not connected to the global frame.
using ServedTrajectory = std::vector<ServedPose>;

// Frames of an agent of which its trajectory has no pose, as GetTrajectoryResponse counts them.
struct UnposedFrames {
  uint64_t lost = 0;
  uint64_t left_out = 0;
  uint64_t dropped = 0;
};
// Returns "12 frames were lost, 300 lie elsewhere or nowhere any more, 0 are kept no more"; all 0
// also if the store is of an older version.
std::string Describe(const UnposedFrames& unposed);

// Returns "localised-00ab..." for a run of a robot that only localised, which has no local map.
std::string NameOfRun(uint64_t run);

Trajectory ToTrajectory(const ServedTrajectory& stored);
size_t CountLocalMaps(const ServedTrajectory& stored);

// Holds what lies in the mission's global frame.
struct ServedMap {
  struct Keyframe {
    KeyframeId id;
    KeyframeId parent;  // Invalid if it has none.
    std::string agent;
    Rigid3d global_from_camera;
  };
  std::vector<Keyframe> keyframes;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::string> point_agents;  // Who made each point; "" if that is not known.

  // What is connected to nothing in the global frame, and so not among the above.
  struct Elsewhere {
    size_t islands = 0;
    std::map<std::string, size_t> keyframes;  // By agent.
    std::map<std::string, size_t> points;
  };
  Elsewhere elsewhere;
};

// Returns "bravo (10 keyframes)" for each robot of which something lies elsewhere, joined by
// commas; "" if nothing does.
std::string Describe(const ServedMap::Elsewhere& elsewhere);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_STORE_SERVED_MISSION_H_

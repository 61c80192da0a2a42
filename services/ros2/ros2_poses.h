// Where a robot is in the frames of REP 105, of what tracking says of a frame.
#ifndef CORBSLAM_SERVICES_ROS2_ROS2_POSES_H_
#define CORBSLAM_SERVICES_ROS2_ROS2_POSES_H_

#include <cstdint>
#include <optional>

#include "client_agent/tracking/tracking_result.h"
#include "slam/camera/recorded_camera.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// What holds for all frames of a robot.
struct Ros2Mounting {
  Rigid3d camera_from_base;  // Of the camera that poses are of.
  // Turns the odom frame of tracking, whose axes are those of the first camera, into ROS's: base
  // stands at its origin at the first frame.
  Rigid3d odom_from_tracked;
  Rigid3d map_from_global;  // Ros2Settings'.
  bool has_store = false;
};

// Where base is the camera itself, odom is turned so that it is level for a level camera.
Ros2Mounting MakeMounting(const RecordedCamera& recorded, const Rigid3d& map_from_global,
                          bool has_store);

struct Ros2Poses {
  int64_t timestamp_ns = 0;
  LocalMapId local_map;
  // Absent while nobody knows how the camera moves: lost, and without an IMU.
  std::optional<Rigid3d> odom_from_base;
  // No picture says the pose, but an IMU.
  bool is_reckoned = false;
  // Motion since the frame before: linear, angular, in base, m/s and rad/s.
  std::optional<Vector6d> velocity;
  // In the local map; absent unless a picture says it.
  std::optional<Rigid3d> local_from_base;
  // Absent as long as nobody knows where the local map lies in the mission. Without a map store the
  // local map is the map.
  std::optional<Similarity3d> map_from_local;
  std::optional<Rigid3d> map_from_base;
  // Of map_from_base, in map's axes; of odom_from_base since the epoch began, in odom's.
  std::optional<Matrix6d> map_covariance;
  std::optional<Matrix6d> odom_covariance;

  // Returns map_from_odom, of which map_from_base is made with odom_from_base; nullopt unless both
  // are there.
  std::optional<Rigid3d> MapFromOdom() const;
};

Ros2Poses MakePoses(const client_agent::TrackingResult& result, const Ros2Mounting& mounting);

// Returns where a pose lies that a similarity moves; its scale moves positions alone.
Rigid3d Moved(const Similarity3d& target_from_source, const Rigid3d& source_from_base);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_ROS2_ROS2_POSES_H_

// The parameters of corbslam_ros2, named as isaac_ros_visual_slam names what it has, too.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_SETTINGS_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_SETTINGS_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/ros2/ros2_names.h"
#include "client_agent/ros2/ros2_parameters.h"
#include "client_agent/ros2/ros2_qos.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

// What a topic that is read is called before remapping, its name and its quality of service.
struct Ros2Input {
  std::string name;   // "visual_slam/image_0".
  std::string topic;  // "/alpha/left/image_raw".
  Ros2Qos qos;
};

struct Ros2Settings {
  bool use_sim_time = false;

  // Cameras. Of a stereo pair 0 is the left one; of an RGB-D camera 0 is the picture, 1 the depth.
  bool is_rgbd = false;              // tracking_mode: stereo, rgbd.
  bool is_compressed = false;        // image_transport: raw, compressed.
  bool depth_is_compressed = false;  // depth_image_transport: raw, compressedDepth.
  Ros2Input images[2];
  Ros2Input infos[2];
  Ros2Input imu;
  double pair_within_ms = 5;  // sync_matching_threshold_ms; 20 of depth.
  bool uses_imu = false;      // enable_imu_fusion.

  // Frames.
  std::string map_frame = "map";
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  std::string camera_frame;  // camera_optical_frame. Empty: that of the pictures' headers.
  std::string imu_frame;     // Empty: that of its messages' headers.
  bool publish_map_to_odom_tf = true;
  bool publish_odom_to_base_tf = true;
  // base_frame to the camera, where the rig file alone says it.
  bool publish_base_to_camera_tf = true;
  // Where the mission's global frame lies in map_frame: x, y, z, roll, pitch, yaw. The same for all
  // robots of a mission. Its default turns a level camera's axes (z ahead, y down) into x ahead, z
  // up.
  Rigid3d map_from_global;

  int path_max_size = 1024;
  double near_map_radius_m = 20;
  double silent_after_s = 3;  // watchdog_s: pictures come and no pose goes out.

  Ros2Qos odometry_qos;
};

// INVALID_ARGUMENT names the parameter, its value and what it wants; also one that is not known,
// and those of isaac_ros_visual_slam that mean what is not done here.
absl::StatusOr<Ros2Settings> ReadRos2Settings(const Ros2Names& names, Ros2Parameters& parameters);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_SETTINGS_H_

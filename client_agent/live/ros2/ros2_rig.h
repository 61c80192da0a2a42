// Makes a rig of what a driver's topics say of its cameras.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_RIG_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_RIG_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/live/ros2/ros2_settings.h"
#include "client_agent/source/bag/messages/ros_messages.h"
#include "client_agent/source/bag/messages/ros_pictures.h"
#include "client_agent/source/bag/messages/transforms.h"
#include "client_agent/source/rig/rig.h"

namespace corbslam::client_agent {

// What is known of one of the two topics of pictures.
struct Ros2Side {
  std::optional<RosPictureForm> form;  // Of its first picture.
  std::string frame_id;                // Likewise.
  std::optional<RosCameraInfo> info;
};

// Returns whether depth is said to be registered to the picture: by the option, by its topic's
// name, or because both have one frame.
bool IsRegistered(const Ros2Settings& settings, const Ros2Side (&sides)[2],
                  std::optional<bool> registers);

// As MakeCameraInfoRig. Both sides have had a picture, and the CameraInfo that is needed is there.
absl::StatusOr<Rig> MakeRos2Rig(const Ros2Settings& settings, const Ros2Side (&sides)[2],
                                const TransformTree& tree, std::optional<bool> registers,
                                bool trust_calibration);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_RIG_H_

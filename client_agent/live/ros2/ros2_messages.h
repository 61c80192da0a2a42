// Takes messages of DDS as those of the bags' readers, without a copy of their pixels.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_MESSAGES_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_MESSAGES_H_

#include <ros2_types.h>

#include <optional>

#include "client_agent/source/bag/messages/ros_messages.h"
#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

RosHeader FromRos2(const std_msgs_msg_dds__Header_& header);
// The data are the message's own.
RosImage FromRos2(const sensor_msgs_msg_dds__Image_& image);
RosCompressedImage FromRos2(const sensor_msgs_msg_dds__CompressedImage_& image);
RosCameraInfo FromRos2(const sensor_msgs_msg_dds__CameraInfo_& info);
// Nullopt: it holds a number that is none.
std::optional<ImuSample> FromRos2(const sensor_msgs_msg_dds__Imu_& imu);
// Nullopt: it is no rigid motion.
std::optional<RosTransform> FromRos2(const geometry_msgs_msg_dds__TransformStamped_& transform);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_MESSAGES_H_

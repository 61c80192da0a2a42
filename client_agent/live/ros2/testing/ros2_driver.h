// Equipment for tests: what a camera's driver for ROS 2 publishes.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_ROS2_TESTING_ROS2_DRIVER_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_ROS2_TESTING_ROS2_DRIVER_H_

#include <gtest/gtest.h>
#include <ros2_types.h>

#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client_agent/live/ros2/ros2_context.h"
#include "client_agent/ros2/ros2_clock.h"
#include "client_agent/ros2/ros2_node.h"
#include "client_agent/ros2/testing/ros2_test_node.h"

namespace corbslam::client_agent {

class Ros2Driver {
 public:
  static constexpr uint32_t kWidth_px = 64;
  static constexpr uint32_t kHeight_px = 48;

  Ros2Driver() : node_(*Ros2Node::Create(TestNode("driver"))) {}

  Ros2Publisher& Topic(const std::string& topic, const dds_topic_descriptor_t& type,
                       const Ros2Qos& qos) {
    Ros2Publisher*& publisher = publishers_[topic];
    if (publisher == nullptr) publisher = *node_->Advertise("rt" + topic, type, qos);
    return *publisher;
  }

  void SendPicture(const std::string& topic, const std::string& frame, int64_t stamp_ns,
                   uint8_t grey, const std::string& encoding = "mono8") {
    std::vector<uint8_t> pixels(kWidth_px * kHeight_px * (encoding == "32FC1" ? 4 : 1), grey);
    if (encoding == "32FC1") {
      const float metres = grey;
      for (size_t i = 0; i < pixels.size(); i += 4) std::memcpy(&pixels[i], &metres, 4);
    }
    sensor_msgs_msg_dds__Image_ image = {};
    image.header = {Ros2Time(stamp_ns), const_cast<char*>(frame.c_str())};
    image.height = kHeight_px;
    image.width = kWidth_px;
    image.encoding = const_cast<char*>(encoding.c_str());
    image.step = static_cast<uint32_t>(pixels.size()) / kHeight_px;
    image.data = {static_cast<uint32_t>(pixels.size()), static_cast<uint32_t>(pixels.size()),
                  pixels.data(), false};
    Topic(topic, sensor_msgs_msg_dds__Image__desc, kSensorData).Publish(&image);
  }

  void SendInfo(const std::string& topic, const std::string& frame, double shift_px_m) {
    sensor_msgs_msg_dds__CameraInfo_ info = {};
    std::string model = "plumb_bob";
    info.header = {Ros2Time(1), const_cast<char*>(frame.c_str())};
    info.height = kHeight_px;
    info.width = kWidth_px;
    info.distortion_model = model.data();
    const double f = 50;
    const double k[9] = {f, 0, 31.5, 0, f, 23.5, 0, 0, 1};
    const double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const double p[12] = {f, 0, 31.5, shift_px_m, 0, f, 23.5, 0, 0, 0, 1, 0};
    std::memcpy(info.k, k, sizeof(k));
    std::memcpy(info.r, r, sizeof(r));
    std::memcpy(info.p, p, sizeof(p));
    Topic(topic, sensor_msgs_msg_dds__CameraInfo__desc, kSensorData).Publish(&info);
  }

  void SendTransform(const std::string& topic, const std::string& parent, const std::string& child,
                     const Eigen::Vector3d& t, const Ros2Qos& qos) {
    geometry_msgs_msg_dds__TransformStamped_ transform = {};
    transform.header = {Ros2Time(1), const_cast<char*>(parent.c_str())};
    transform.child_frame_id = const_cast<char*>(child.c_str());
    transform.transform.translation = {t.x(), t.y(), t.z()};
    transform.transform.rotation = {0, 0, 0, 1};
    tf2_msgs_msg_dds__TFMessage_ message = {};
    message.transforms = {1, 1, &transform, false};
    Topic(topic, tf2_msgs_msg_dds__TFMessage__desc, qos).Publish(&message);
  }

 private:
  const std::unique_ptr<Ros2Node> node_;
  std::map<std::string, Ros2Publisher*> publishers_;
};

// Returns a context of the test's domain with these parameters.
inline std::shared_ptr<Ros2Context> TestContext(const std::vector<Ros2Rule>& parameters = {}) {
  Ros2Arguments arguments;
  arguments.parameters = parameters;
  const auto names = Ros2Names::Make("visual_slam", {});
  auto read = Ros2Parameters::Read(arguments, *names);
  const auto settings = ReadRos2Settings(*names, *read);
  EXPECT_TRUE(settings.ok()) << settings.status();
  auto context = std::make_shared<Ros2Context>(*names, *settings, TestNode("visual_slam"));
  const absl::Status begun = context->Begin();
  EXPECT_TRUE(begun.ok()) << begun;
  return context;
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_ROS2_TESTING_ROS2_DRIVER_H_

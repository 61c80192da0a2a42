// A topic of pictures: what they are, and which camera took them.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_PICTURE_TOPIC_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_PICTURE_TOPIC_H_

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/source/bag/bag_contents.h"
#include "client_agent/source/bag/messages/ros_messages.h"
#include "client_agent/source/bag/messages/ros_pictures.h"
#include "client_agent/source/bag/messages/transforms.h"

namespace corbslam::client_agent {

struct PictureTopic {
  const BagTopic* topic = nullptr;
  std::string base;  // The name without its transport's ending.
  bool is_compressed = false;
  RosPictureForm form;   // Of its first picture that can be read.
  std::string frame_id;  // Likewise.
  bool is_depth = false;
  // Why none of its pictures can be played; empty: they can.
  std::string problem;
  std::optional<RosCameraInfo> info;
  std::string info_topic;
  // The calibration was another one later in the bag.
  bool info_changes = false;

  const std::string& name() const { return topic->name; }
};

// Looks at the first pictures of each topic, and for its CameraInfo.
std::vector<PictureTopic> LookAtPictures(const BagContents& contents);

// Takes the CameraInfo of a topic that was named. Errors name it.
absl::Status UseCameraInfo(const BagContents& contents, const std::string& topic,
                           PictureTopic& picture);

// Returns the fixed frames of the robot.
TransformTree ReadFixedTransforms(const BagContents& contents);

// Each decodes one of the topic's messages; errors name bag, topic and time.
absl::StatusOr<cv::Mat> ReadBagGrey(const BagContents& contents, const PictureTopic& picture,
                                    const RecordedPlace& place, int64_t timestamp_ns);
absl::StatusOr<cv::Mat> ReadBagDepth(const BagContents& contents, const PictureTopic& picture,
                                     const RecordedPlace& place, int64_t timestamp_ns);

// Returns "/left/image_raw (mono8, 752x480)".
std::string DescribeTopic(const PictureTopic& picture);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_PICTURE_TOPIC_H_

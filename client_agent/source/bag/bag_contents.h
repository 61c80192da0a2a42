// What is in a bag: its topics, and where each of its pictures lies.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_CONTENTS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_CONTENTS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/files/bag_recording.h"
#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

struct PictureMessage {
  int64_t stamp_ns = 0;     // Of its header.
  int64_t recorded_ns = 0;  // The recorder's.
  RecordedPlace place;
  uint32_t publisher = 0;  // Index into BagTopic::publishers.
};

// Messages of one topic that differ in who sent them or in which frame they are.
struct BagPublisher {
  size_t channel = 0;  // Of the recording.
  std::string frame_id;
  std::string node;  // ROS 1's name of it; empty: not known.
  uint64_t messages = 0;
  int64_t first_ns = 0;  // By the recorder's time.
  int64_t last_ns = 0;
};

struct ImuMessage {
  ImuSample sample;  // Stamped by its header.
  int64_t recorded_ns = 0;
};

struct BagTopic {
  std::string name;
  std::string type;
  std::string encoding_name;
  BagEncoding encoding = BagEncoding::kOther;
  uint64_t messages = 0;
  uint64_t bytes = 0;
  int64_t first_ns = 0;  // By the recorder's time; 0 without messages.
  int64_t last_ns = 0;
  // Of pictures alone, in the order of the file.
  std::vector<PictureMessage> pictures;
  std::vector<BagPublisher> publishers;
  uint64_t unreadable = 0;  // Pictures whose header can't be read, measurements that are none.
  // Of an IMU's alone, in the order of the file: those in the frame of the first.
  std::vector<ImuMessage> measured;
  std::string imu_frame_id;
  uint64_t of_other_frames = 0;
  // Of CameraInfo the first, and a few on the way; of fixed transforms up to a thousand.
  std::vector<RecordedPlace> kept;

  bool HasPictures() const;
  bool IsCameraInfo() const;
  bool IsImu() const;
  bool IsFixedTransforms() const;
};

struct BagContents {
  std::unique_ptr<BagRecording> recording;
  std::vector<BagTopic> topics;  // By name, then type.
  uint64_t messages = 0;
  int64_t first_ns = 0;
  int64_t last_ns = 0;

  const BagTopic* Find(const std::string& name) const;
};

// Reads through the bag once. Errors name the file.
absl::StatusOr<std::shared_ptr<const BagContents>> ReadBagContents(const std::string& path);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_CONTENTS_H_

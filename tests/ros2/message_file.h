// Messages as CDR: FILE has their bytes, FILE.jsonl a line each
// (tests/interchange/bags/write_mcap.mjs).
#ifndef CORBSLAM_TESTS_ROS2_MESSAGE_FILE_H_
#define CORBSLAM_TESTS_ROS2_MESSAGE_FILE_H_

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam::tests {

struct CdrMessage {
  std::string topic;  // ROS 2's name: "/left/image_raw".
  std::string type;   // "sensor_msgs/msg/Image".
  int64_t time_ns = 0;
  std::string bytes;
};

// INVALID_ARGUMENT names the file and the line.
absl::StatusOr<std::vector<CdrMessage>> ReadMessages(const std::string& file);

class MessageFile {
 public:
  explicit MessageFile(const std::string& file)
      : bytes_(file, std::ios::binary), lines_(file + ".jsonl") {}
  void Add(const CdrMessage& message);

 private:
  std::ofstream bytes_;
  std::ofstream lines_;
  uint64_t at_ = 0;
};

// Returns DDS's names of what ROS 2 names so.
std::string DdsTypeOf(const std::string& type);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_ROS2_MESSAGE_FILE_H_

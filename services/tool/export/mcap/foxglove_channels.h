// Writes protobuf messages to an MCAP file, a channel for each topic.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FOXGLOVE_CHANNELS_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FOXGLOVE_CHANNELS_H_

#include <google/protobuf/message.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/tool/export/mcap/mcap_writer.h"

namespace corbslam::services {

// Not thread-safe. Errors are the writer's.
class FoxgloveChannels {
 public:
  explicit FoxgloveChannels(McapWriter writer) : writer_(std::move(writer)) {}

  // Begins the topic, and the message's schema, with their first message. A topic has messages of
  // one kind.
  absl::Status Write(const std::string& topic, uint64_t time_ns,
                     const google::protobuf::Message& message);

  McapWriter& writer() { return writer_; }

 private:
  absl::StatusOr<uint16_t> FindSchema(const google::protobuf::Descriptor& descriptor);
  absl::StatusOr<uint16_t> FindChannel(const std::string& topic,
                                       const google::protobuf::Descriptor& descriptor);

  McapWriter writer_;
  std::map<std::string, uint16_t> schemas_;   // By the messages' names.
  std::map<std::string, uint16_t> channels_;  // By topic.
  std::string bytes_;                         // Kept for its memory.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FOXGLOVE_CHANNELS_H_

#include "services/tool/export/mcap/foxglove_channels.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <set>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr char kEncoding[] = "protobuf";

// Adds the file behind those that it imports.
void AddFile(const google::protobuf::FileDescriptor& file, std::set<std::string>& added,
             google::protobuf::FileDescriptorSet& files) {
  if (!added.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) AddFile(*file.dependency(i), added, files);
  file.CopyTo(files.add_file());
}

std::string DescribeSchema(const google::protobuf::Descriptor& descriptor) {
  google::protobuf::FileDescriptorSet files;
  std::set<std::string> added;
  AddFile(*descriptor.file(), added, files);
  return files.SerializeAsString();
}

}  // namespace

absl::StatusOr<uint16_t> FoxgloveChannels::FindSchema(
    const google::protobuf::Descriptor& descriptor) {
  if (const auto known = schemas_.find(descriptor.full_name()); known != schemas_.end()) {
    return known->second;
  }
  ASSIGN_OR_RETURN(const uint16_t id, writer_.AddSchema({descriptor.full_name(), kEncoding,
                                                         DescribeSchema(descriptor)}));
  schemas_[descriptor.full_name()] = id;
  return id;
}

absl::StatusOr<uint16_t> FoxgloveChannels::FindChannel(
    const std::string& topic, const google::protobuf::Descriptor& descriptor) {
  if (const auto known = channels_.find(topic); known != channels_.end()) return known->second;
  ASSIGN_OR_RETURN(const uint16_t schema, FindSchema(descriptor));
  ASSIGN_OR_RETURN(const uint16_t id, writer_.AddChannel(schema, topic, kEncoding));
  channels_[topic] = id;
  return id;
}

absl::Status FoxgloveChannels::Write(const std::string& topic, uint64_t time_ns,
                                     const google::protobuf::Message& message) {
  ASSIGN_OR_RETURN(const uint16_t channel, FindChannel(topic, *message.GetDescriptor()));
  if (!message.SerializeToString(&bytes_)) {
    return absl::ResourceExhaustedError(
        absl::StrCat("a message of ", topic, " is longer than 2 GiB"));
  }
  return writer_.Write(channel, time_ns, bytes_);
}

}  // namespace corbslam::services

// All files of a bag as one recording.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_RECORDING_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_RECORDING_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/source/bag/files/bag_file.h"

namespace corbslam::client_agent {

struct RecordedPlace {
  uint32_t file = 0;
  BagPlace place;
};

class BagRecording {
 public:
  // Of `message` the channel counts in channels() of the recording.
  using Use = absl::FunctionRef<void(const ScannedMessage& message, uint32_t file)>;

  // Opens the bag's files. Errors name the file. A split bag's file that can't be opened is left
  // out, which notes() say.
  static absl::StatusOr<std::unique_ptr<BagRecording>> Open(const std::string& path);

  // Reads through all files once. Called once, before all below.
  void Scan(Use use);

  const std::string& path() const { return path_; }
  std::string format() const;
  size_t file_count() const { return files_.size(); }
  const std::vector<BagChannel>& channels() const { return channels_; }
  std::vector<std::string> notes() const;
  // Returns a whole message. Any thread.
  absl::StatusOr<std::string> Read(const RecordedPlace& place) const;

 private:
  size_t NumberOf(const BagChannel& channel);

  std::string path_;
  std::vector<std::unique_ptr<BagFile>> files_;
  std::string message_compression_;
  std::vector<std::string> notes_;
  std::vector<BagChannel> channels_;
  std::map<BagChannel, size_t> numbers_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_RECORDING_H_

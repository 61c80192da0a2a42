// A file that a robot's messages were recorded in, whatever its format.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_FILE_H_

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// How messages were made bytes.
enum class BagEncoding { kRos1, kCdr, kOther };

// Messages of one type from one publisher, as far as the format tells publishers apart.
struct BagChannel {
  std::string topic;
  std::string type;           // "sensor_msgs/Image", for ROS 2's "sensor_msgs/msg/Image" as well.
  std::string encoding_name;  // As the file has it: "cdr", "ros1".
  BagEncoding encoding = BagEncoding::kOther;
  std::string publisher;  // ROS 1's callerid; empty: not known.

  friend auto operator<=>(const BagChannel&, const BagChannel&) = default;
};

// Where a message lies in its file. Only the file itself understands it.
struct BagPlace {
  static constexpr uint32_t kNoChunk = UINT32_MAX;
  uint32_t chunk = kNoChunk;
  uint32_t size = 0;
  uint64_t offset = 0;
};

// How many bytes of each message a scan gives: a header's time and name of frame, and all that an
// IMU measured.
inline constexpr size_t kBagHeadBytes = 512;

struct ScannedMessage {
  size_t channel = 0;       // Index into channels().
  int64_t recorded_ns = 0;  // When the recorder got it.
  BagPlace place;
  absl::string_view head;  // Its first bytes, kBagHeadBytes at most.
};

class BagFile {
 public:
  using Use = absl::FunctionRef<void(const ScannedMessage&)>;

  virtual ~BagFile() = default;

  // "ROS 1 bag", "MCAP" or "SQLite (rosbag2)".
  virtual absl::string_view format() const = 0;
  // Reads through the file once, in the order in which it was written; no index is needed. Where
  // the file is damaged it ends there, and notes() say so. Called once, before all below.
  virtual void Scan(Use use) = 0;
  virtual const std::vector<BagChannel>& channels() const = 0;
  // Sentences that name the file: that it was not closed, where it is damaged.
  virtual const std::vector<std::string>& notes() const = 0;
  // Returns a whole message. Any thread. Errors name the file and the offset.
  virtual absl::StatusOr<std::string> Read(const BagPlace& place) const = 0;
};

// Opens a file by its first bytes. INVALID_ARGUMENT names it, and what it is instead.
absl::StatusOr<std::unique_ptr<BagFile>> OpenBagFile(const std::string& path);

// Returns the type's name without ROS 2's "/msg/".
std::string PlainTypeName(absl::string_view type);
BagEncoding EncodingOfName(absl::string_view name);
// Returns a name of the bag as it can be printed: no control characters, not endless.
std::string CleanName(absl::string_view name);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_FILE_H_

// Collects records of a chunk until it is written.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_CHUNK_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_CHUNK_H_

#include <cstddef>
#include <cstdint>
#include <map>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "services/tool/export/mcap/mcap_bytes.h"
#include "services/tool/export/mcap/mcap_output.h"

namespace corbslam::services {

struct McapMessage {
  uint16_t channel = 0;
  uint32_t sequence = 0;
  uint64_t time_ns = 0;  // When it was logged and published.
  absl::string_view data;
};

// From the first to the last of some messages; both are 0 where there is none.
struct McapSpan {
  uint64_t first_ns = 0;
  uint64_t last_ns = 0;
  bool is_empty = true;

  void Add(uint64_t time_ns);
};

// One chunk without compression. A value; not thread-safe.
class McapChunk {
 public:
  // Adds the record of a schema or channel.
  void Add(absl::string_view record) { records_.AddRaw(record); }
  void Add(const McapMessage& message);
  size_t size() const { return records_.size(); }
  bool has_messages() const { return !span_.is_empty; }
  absl::string_view records() const { return records_.view(); }

  // Writes the chunk and its message indexes, and returns the content of its ChunkIndex record.
  // The chunk is empty then.
  absl::StatusOr<McapBytes> WriteTo(McapOutput& output);

 private:
  // Messages of one channel, each as its time and its offset in the chunk.
  struct Channel {
    McapBytes entries;
  };

  absl::Status WriteRecords(McapOutput& output) const;

  McapBytes records_;
  std::map<uint16_t, Channel> channels_;
  McapSpan span_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_CHUNK_H_

// Writes MCAP files, the recordings that Foxglove and Rerun open (https://mcap.dev/spec).
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_WRITER_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_WRITER_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "services/tool/export/mcap/mcap_bytes.h"
#include "slam/util/atomic_file.h"

namespace corbslam::services {

struct McapSchema {
  std::string name;      // "foxglove.Log".
  std::string encoding;  // "protobuf": the data is a FileDescriptorSet.
  std::string data;
};

// One file, in chunks without compression, with the indexes and checksums that readers use. It
// holds one chunk and the indexes of those before. Not thread-safe. Errors of the file name it, and
// are those of AtomicFile; after an error the caller gives the writer up.
class McapWriter {
 public:
  using Metadata = std::map<std::string, std::string>;

  // Begins a file that takes the place of one at the path once it is finished. A chunk is written
  // when it has `chunk_bytes`; only a single message may make it longer.
  static absl::StatusOr<McapWriter> Create(const std::string& path, absl::string_view library,
                                           size_t chunk_bytes = size_t{1} << 20);

  // Both return the new id. RESOURCE_EXHAUSTED if there are 65,535 already. All texts are UTF-8.
  absl::StatusOr<uint16_t> AddSchema(const McapSchema& schema);
  absl::StatusOr<uint16_t> AddChannel(uint16_t schema, absl::string_view topic,
                                      absl::string_view message_encoding,
                                      const Metadata& metadata = {});
  // NOT_FOUND for a channel that was not added. Times need not ascend, but readers have less work
  // where they do.
  absl::Status Write(uint16_t channel, uint64_t time_ns, absl::string_view data);
  absl::Status AddMetadata(absl::string_view name, const Metadata& metadata);
  // Gives the file its name, durably. The caller does so once, as the last call.
  absl::Status Finish();

  size_t bytes_held() const { return chunk_.size(); }

 private:
  // Times of some messages, from the first to the last; both are 0 where there is none.
  struct Span {
    uint64_t first_ns = 0;
    uint64_t last_ns = 0;
    bool is_empty = true;

    void Add(uint64_t time_ns);
  };

  McapWriter(AtomicFile file, size_t chunk_bytes)
      : file_(std::move(file)), chunk_bytes_(chunk_bytes) {}

  absl::Status Append(absl::string_view bytes);
  // Adds a record to the chunk, and to the summary that repeats it.
  void AddToBoth(McapOpcode opcode, const McapBytes& content);
  absl::Status WriteRecords();
  absl::Status WriteChunk();
  absl::Status WriteSummary();

  AtomicFile file_;
  size_t chunk_bytes_;
  uint64_t offset_ = 0;
  uint32_t crc_ = 0;  // Of all that was appended.
  // The chunk's records, and the time and offset of its messages by their channel.
  McapBytes chunk_;
  std::map<uint16_t, McapBytes> chunk_index_;
  Span chunk_span_;
  // What stands at the file's end, by its kind, and what is counted there.
  std::map<McapOpcode, McapBytes> summary_;
  std::map<uint16_t, uint64_t> messages_;  // How many each channel has.
  Span span_;
  uint16_t schemas_ = 0;
  uint16_t channels_ = 0;
  uint32_t chunks_ = 0;
  uint32_t metadata_ = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_WRITER_H_

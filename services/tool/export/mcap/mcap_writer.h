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
#include "services/tool/export/mcap/mcap_chunk.h"
#include "services/tool/export/mcap/mcap_output.h"
#include "services/tool/export/mcap/mcap_summary.h"

namespace corbslam::services {

struct McapSchema {
  std::string name;      // "foxglove.Log".
  std::string encoding;  // "protobuf": the data is a FileDescriptorSet.
  std::string data;
};

// One file, in chunks without compression, with all indexes and checksums. It holds one chunk and
// the indexes of those before. Not thread-safe. Errors of the file name it, and are those of
// WholeFile; after an error the caller gives the writer up.
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
  McapWriter(McapOutput output, size_t chunk_bytes)
      : output_(std::move(output)), chunk_bytes_(chunk_bytes) {}

  absl::Status WriteChunk();

  McapOutput output_;
  size_t chunk_bytes_;
  McapChunk chunk_;
  McapSummary summary_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_WRITER_H_

// Counts and checks what goes into a file.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_OUTPUT_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_OUTPUT_H_

#include <cstdint>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "services/tool/export/mcap/crc32.h"
#include "slam/util/whole_file.h"

namespace corbslam::services {

// A file that is being written, with its offset and a checksum. Errors are the file's.
class McapOutput {
 public:
  explicit McapOutput(WholeFile file) : file_(std::move(file)) {}

  absl::Status Append(absl::string_view bytes) {
    offset_ += bytes.size();
    crc_ = ExtendCrc32(crc_, bytes);
    return file_.Append(bytes);
  }
  absl::Status Finish() { return file_.Finish(); }

  uint64_t offset() const { return offset_; }
  // Returns the checksum of all since the file began, or since the last call of BeginCrc.
  uint32_t crc() const { return crc_; }
  void BeginCrc() { crc_ = 0; }

 private:
  WholeFile file_;
  uint64_t offset_ = 0;
  uint32_t crc_ = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_OUTPUT_H_

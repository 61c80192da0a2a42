// Collects what the end of an MCAP file repeats and counts, so that a reader needs not look at the
// whole file.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_SUMMARY_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_SUMMARY_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "services/tool/export/mcap/mcap_bytes.h"
#include "services/tool/export/mcap/mcap_chunk.h"
#include "services/tool/export/mcap/mcap_output.h"

namespace corbslam::services {

// A value; not thread-safe.
class McapSummary {
 public:
  // These two are given the whole records.
  void AddSchema(absl::string_view record);
  void AddChannel(absl::string_view record);
  // Returns the message's sequence number: how many the channel has had.
  uint32_t CountMessage(uint16_t channel, uint64_t time_ns);
  void AddChunk(const McapBytes& index);
  void AddMetadata(uint64_t offset, uint64_t length, absl::string_view name);

  uint16_t schemas() const { return schemas_; }
  uint16_t channels() const { return channels_; }

  // Writes the summary section, the summary offset section and the footer.
  absl::Status WriteTo(McapOutput& output);

 private:
  void AddStatistics();

  std::map<McapOpcode, McapBytes> groups_;  // Records by their kind.
  uint16_t schemas_ = 0;
  uint16_t channels_ = 0;
  uint32_t chunks_ = 0;
  uint32_t metadata_ = 0;
  McapSpan span_;
  std::map<uint16_t, uint64_t> messages_;  // How many each channel has.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MCAP_SUMMARY_H_

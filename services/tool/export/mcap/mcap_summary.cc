#include "services/tool/export/mcap/mcap_summary.h"

#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr uint32_t kAttachments = 0;

// Bytes of a footer's content: two offsets and the checksum.
constexpr uint64_t kFooterBytes = 8 + 8 + 4;

}  // namespace

void McapSummary::AddSchema(absl::string_view record) {
  groups_[McapOpcode::kSchema].AddRaw(record);
  ++schemas_;
}

void McapSummary::AddChannel(absl::string_view record) {
  groups_[McapOpcode::kChannel].AddRaw(record);
  ++channels_;
}

uint32_t McapSummary::CountMessage(uint16_t channel, uint64_t time_ns) {
  span_.Add(time_ns);
  return static_cast<uint32_t>(messages_[channel]++);
}

void McapSummary::AddChunk(const McapBytes& index) {
  groups_[McapOpcode::kChunkIndex].AddRecord(McapOpcode::kChunkIndex, index);
  ++chunks_;
}

void McapSummary::AddMetadata(uint64_t offset, uint64_t length, absl::string_view name) {
  McapBytes index;
  index.Add(offset).Add(length).Add(name);
  groups_[McapOpcode::kMetadataIndex].AddRecord(McapOpcode::kMetadataIndex, index);
  ++metadata_;
}

void McapSummary::AddStatistics() {
  uint64_t messages = 0;
  for (const auto& [channel, count] : messages_) messages += count;
  McapBytes statistics;
  statistics.Add(messages).Add(schemas_).Add(uint32_t{channels_}).Add(kAttachments);
  statistics.Add(metadata_).Add(chunks_).Add(span_.first_ns).Add(span_.last_ns).Add(messages_);
  groups_[McapOpcode::kStatistics].AddRecord(McapOpcode::kStatistics, statistics);
}

absl::Status McapSummary::WriteTo(McapOutput& output) {
  AddStatistics();
  output.BeginCrc();
  const uint64_t summary_start = output.offset();
  McapBytes offsets;
  for (const auto& [opcode, records] : groups_) {
    McapBytes offset;
    offset.Add(opcode).Add(output.offset()).Add(uint64_t{records.size()});
    offsets.AddRecord(McapOpcode::kSummaryOffset, offset);
    RETURN_IF_ERROR(output.Append(records.view()));
  }
  const uint64_t offsets_start = output.offset();
  RETURN_IF_ERROR(output.Append(offsets.view()));
  // The checksum covers the footer up to the checksum itself.
  McapBytes footer;
  footer.Add(McapOpcode::kFooter).Add(kFooterBytes).Add(summary_start).Add(offsets_start);
  RETURN_IF_ERROR(output.Append(footer.view()));
  return output.Append(McapBytes().Add(output.crc()).view());
}

}  // namespace corbslam::services

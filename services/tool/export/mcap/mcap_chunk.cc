#include "services/tool/export/mcap/mcap_chunk.h"

#include <algorithm>

#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::string_view kNoCompression;

// Bytes of a message's record before its data: channel, sequence and two times.
constexpr uint64_t kMessageHead = 2 + 4 + 8 + 8;

}  // namespace

void McapSpan::Add(uint64_t time_ns) {
  first_ns = is_empty ? time_ns : std::min(first_ns, time_ns);
  last_ns = is_empty ? time_ns : std::max(last_ns, time_ns);
  is_empty = false;
}

void McapChunk::Add(const McapMessage& message) {
  channels_[message.channel].entries.Add(message.time_ns).Add(uint64_t{records_.size()});
  span_.Add(message.time_ns);
  records_.Add(McapOpcode::kMessage).Add(kMessageHead + message.data.size());
  records_.Add(message.channel).Add(message.sequence).Add(message.time_ns).Add(message.time_ns);
  records_.AddRaw(message.data);
}

// The records are appended as they are: a copy of a long chunk would take its memory twice.
absl::Status McapChunk::WriteRecords(McapOutput& output) const {
  McapBytes head;
  head.Add(span_.first_ns).Add(span_.last_ns).Add(uint64_t{records_.size()});
  head.Add(ExtendCrc32(0, records_.view())).Add(kNoCompression).Add(uint64_t{records_.size()});
  McapBytes begin;
  begin.Add(McapOpcode::kChunk).Add(uint64_t{head.size() + records_.size()}).AddRaw(head.view());
  RETURN_IF_ERROR(output.Append(begin.view()));
  return output.Append(records_.view());
}

absl::StatusOr<McapBytes> McapChunk::WriteTo(McapOutput& output) {
  const uint64_t start = output.offset();
  RETURN_IF_ERROR(WriteRecords(output));
  const uint64_t end = output.offset();
  std::map<uint16_t, uint64_t> index_offsets;
  for (const auto& [id, channel] : channels_) {
    index_offsets[id] = output.offset();
    McapBytes content;
    content.Add(id).Add(channel.entries.view());
    RETURN_IF_ERROR(
        output.Append(McapBytes().AddRecord(McapOpcode::kMessageIndex, content).view()));
  }
  McapBytes index;
  index.Add(span_.first_ns).Add(span_.last_ns).Add(start).Add(end - start).Add(index_offsets);
  index.Add(output.offset() - end).Add(kNoCompression);
  index.Add(uint64_t{records_.size()}).Add(uint64_t{records_.size()});
  *this = McapChunk();
  return index;
}

}  // namespace corbslam::services

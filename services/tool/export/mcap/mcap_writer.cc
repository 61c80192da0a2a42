#include "services/tool/export/mcap/mcap_writer.h"

#include <algorithm>
#include <limits>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Messages are as a program makes them, not as one of the robots' frameworks does.
constexpr absl::string_view kNoProfile;
constexpr absl::string_view kNoCompression;
constexpr uint32_t kAttachments = 0;
constexpr uint64_t kNoOffsets = 0;  // The summary is short: nothing says where its groups begin.

// Bytes of a message's record before its data: channel, sequence and two times.
constexpr uint64_t kMessageHead = 2 + 4 + 8 + 8;
// Bytes of a footer's content: two offsets and the checksum.
constexpr uint64_t kFooterBytes = 8 + 8 + 4;

absl::Status CheckRoom(absl::string_view what, uint16_t count) {
  if (count < std::numeric_limits<uint16_t>::max()) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("an MCAP file has no more than ", count, " ", what));
}

}  // namespace

void McapWriter::Span::Add(uint64_t time_ns) {
  first_ns = is_empty ? time_ns : std::min(first_ns, time_ns);
  last_ns = is_empty ? time_ns : std::max(last_ns, time_ns);
  is_empty = false;
}

absl::StatusOr<McapWriter> McapWriter::Create(const std::string& path, absl::string_view library,
                                              size_t chunk_bytes) {
  ASSIGN_OR_RETURN(AtomicFile file, AtomicFile::Create(path, AtomicFile::Old::kReplaced,
                                                       AtomicFile::Readers::kOthersToo));
  McapWriter writer(std::move(file), chunk_bytes);
  McapBytes header;
  header.Add(kNoProfile).Add(library);
  McapBytes begin;
  begin.AddRaw(kMcapMagic).AddRecord(McapOpcode::kHeader, header);
  RETURN_IF_ERROR(writer.Append(begin.view()));
  return writer;
}

absl::Status McapWriter::Append(absl::string_view bytes) {
  offset_ += bytes.size();
  crc_ = ExtendMcapCrc(crc_, bytes);
  return file_.Append(bytes);
}

void McapWriter::AddToBoth(McapOpcode opcode, const McapBytes& content) {
  chunk_.AddRecord(opcode, content);
  summary_[opcode].AddRecord(opcode, content);
}

absl::StatusOr<uint16_t> McapWriter::AddSchema(const McapSchema& schema) {
  RETURN_IF_ERROR(CheckRoom("schemas", schemas_));
  // 0 is no schema.
  McapBytes content;
  content.Add(++schemas_).Add(schema.name).Add(schema.encoding).Add(schema.data);
  AddToBoth(McapOpcode::kSchema, content);
  return schemas_;
}

absl::StatusOr<uint16_t> McapWriter::AddChannel(uint16_t schema, absl::string_view topic,
                                                absl::string_view message_encoding,
                                                const Metadata& metadata) {
  RETURN_IF_ERROR(CheckRoom("channels", channels_));
  McapBytes content;
  content.Add(++channels_).Add(schema).Add(topic).Add(message_encoding).Add(metadata);
  AddToBoth(McapOpcode::kChannel, content);
  return channels_;
}

absl::Status McapWriter::Write(uint16_t channel, uint64_t time_ns, absl::string_view data) {
  if (channel == 0 || channel > channels_) {
    return absl::NotFoundError(absl::StrCat("there is no MCAP channel ", channel));
  }
  // A long message goes into a chunk of its own.
  if (!chunk_span_.is_empty && chunk_.size() + data.size() > chunk_bytes_) {
    RETURN_IF_ERROR(WriteChunk());
  }
  chunk_index_[channel].Add(time_ns).Add(uint64_t{chunk_.size()});
  chunk_span_.Add(time_ns);
  span_.Add(time_ns);
  const auto sequence = static_cast<uint32_t>(messages_[channel]++);
  chunk_.Add(McapOpcode::kMessage).Add(kMessageHead + data.size());
  chunk_.Add(channel).Add(sequence).Add(time_ns).Add(time_ns).AddRaw(data);
  return chunk_.size() < chunk_bytes_ ? absl::OkStatus() : WriteChunk();
}

absl::Status McapWriter::AddMetadata(absl::string_view name, const Metadata& metadata) {
  McapBytes content;
  content.Add(name).Add(metadata);
  McapBytes record;
  record.AddRecord(McapOpcode::kMetadata, content);
  McapBytes index;
  index.Add(offset_).Add(uint64_t{record.size()}).Add(name);
  summary_[McapOpcode::kMetadataIndex].AddRecord(McapOpcode::kMetadataIndex, index);
  ++metadata_;
  return Append(record.view());
}

// The chunk's records are appended as they are: a copy of a long one would take its memory twice.
absl::Status McapWriter::WriteRecords() {
  const uint64_t size = chunk_.size();
  McapBytes head;
  head.Add(chunk_span_.first_ns).Add(chunk_span_.last_ns).Add(size);
  head.Add(ExtendMcapCrc(0, chunk_.view())).Add(kNoCompression).Add(size);
  McapBytes begin;
  begin.Add(McapOpcode::kChunk).Add(uint64_t{head.size() + size}).AddRaw(head.view());
  RETURN_IF_ERROR(Append(begin.view()));
  return Append(chunk_.view());
}

absl::Status McapWriter::WriteChunk() {
  if (chunk_span_.is_empty) return absl::OkStatus();
  const uint64_t size = chunk_.size();
  const uint64_t start = offset_;
  RETURN_IF_ERROR(WriteRecords());
  const uint64_t end = offset_;
  std::map<uint16_t, uint64_t> index_offsets;
  McapBytes indexes;
  for (const auto& [channel, entries] : chunk_index_) {
    index_offsets[channel] = end + indexes.size();
    McapBytes content;
    indexes.AddRecord(McapOpcode::kMessageIndex, content.Add(channel).Add(entries.view()));
  }
  RETURN_IF_ERROR(Append(indexes.view()));
  McapBytes index;
  index.Add(chunk_span_.first_ns).Add(chunk_span_.last_ns).Add(start).Add(end - start);
  index.Add(index_offsets).Add(uint64_t{indexes.size()}).Add(kNoCompression).Add(size).Add(size);
  summary_[McapOpcode::kChunkIndex].AddRecord(McapOpcode::kChunkIndex, index);
  ++chunks_;
  chunk_.Clear();
  chunk_index_.clear();
  chunk_span_ = Span();
  return absl::OkStatus();
}

absl::Status McapWriter::WriteSummary() {
  uint64_t messages = 0;
  for (const auto& [channel, count] : messages_) messages += count;
  McapBytes statistics;
  statistics.Add(messages).Add(schemas_).Add(uint32_t{channels_}).Add(kAttachments);
  statistics.Add(metadata_).Add(chunks_).Add(span_.first_ns).Add(span_.last_ns).Add(messages_);
  summary_[McapOpcode::kStatistics].AddRecord(McapOpcode::kStatistics, statistics);
  const uint64_t start = offset_;
  McapBytes end;
  for (const auto& [opcode, records] : summary_) end.AddRaw(records.view());
  // The checksum covers the summary and the footer up to the checksum itself.
  end.Add(McapOpcode::kFooter).Add(kFooterBytes).Add(start).Add(kNoOffsets);
  end.Add(ExtendMcapCrc(0, end.view())).AddRaw(kMcapMagic);
  return Append(end.view());
}

absl::Status McapWriter::Finish() {
  RETURN_IF_ERROR(WriteChunk());
  // What no message came behind: a chunk without messages would begin at time 0.
  RETURN_IF_ERROR(Append(chunk_.view()));
  const McapBytes data_crc = McapBytes().Add(crc_);
  RETURN_IF_ERROR(Append(McapBytes().AddRecord(McapOpcode::kDataEnd, data_crc).view()));
  RETURN_IF_ERROR(WriteSummary());
  return file_.Finish();
}

}  // namespace corbslam::services

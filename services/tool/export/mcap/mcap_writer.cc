#include "services/tool/export/mcap/mcap_writer.h"

#include <limits>

#include "absl/strings/str_cat.h"
#include "services/tool/export/mcap/mcap_bytes.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Messages are as a program makes them, not as one of the robots' frameworks does.
constexpr absl::string_view kNoProfile;

absl::Status CheckRoom(absl::string_view what, uint16_t count) {
  if (count < std::numeric_limits<uint16_t>::max()) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("an MCAP file has no more than ", count, " ", what));
}

}  // namespace

absl::StatusOr<McapWriter> McapWriter::Create(const std::string& path, absl::string_view library,
                                              size_t chunk_bytes) {
  ASSIGN_OR_RETURN(WholeFile file, WholeFile::Create(path, WholeFile::Old::kReplaced,
                                                     WholeFile::Readers::kOthersToo));
  McapWriter writer(McapOutput(std::move(file)), chunk_bytes);
  McapBytes header;
  header.Add(kNoProfile).Add(library);
  McapBytes begin;
  begin.AddRaw(kMcapMagic).AddRecord(McapOpcode::kHeader, header);
  RETURN_IF_ERROR(writer.output_.Append(begin.view()));
  return writer;
}

absl::StatusOr<uint16_t> McapWriter::AddSchema(const McapSchema& schema) {
  RETURN_IF_ERROR(CheckRoom("schemas", summary_.schemas()));
  // 0 is no schema.
  const auto id = static_cast<uint16_t>(summary_.schemas() + 1);
  McapBytes content;
  content.Add(id).Add(schema.name).Add(schema.encoding).Add(schema.data);
  McapBytes record;
  record.AddRecord(McapOpcode::kSchema, content);
  chunk_.Add(record.view());
  summary_.AddSchema(record.view());
  return id;
}

absl::StatusOr<uint16_t> McapWriter::AddChannel(uint16_t schema, absl::string_view topic,
                                                absl::string_view message_encoding,
                                                const Metadata& metadata) {
  RETURN_IF_ERROR(CheckRoom("channels", summary_.channels()));
  const auto id = static_cast<uint16_t>(summary_.channels() + 1);
  McapBytes content;
  content.Add(id).Add(schema).Add(topic).Add(message_encoding).Add(metadata);
  McapBytes record;
  record.AddRecord(McapOpcode::kChannel, content);
  chunk_.Add(record.view());
  summary_.AddChannel(record.view());
  return id;
}

absl::Status McapWriter::Write(uint16_t channel, uint64_t time_ns, absl::string_view data) {
  if (channel == 0 || channel > summary_.channels()) {
    return absl::NotFoundError(absl::StrCat("there is no MCAP channel ", channel));
  }
  // A long message goes into a chunk of its own.
  if (chunk_.has_messages() && chunk_.size() + data.size() > chunk_bytes_) {
    RETURN_IF_ERROR(WriteChunk());
  }
  chunk_.Add({channel, summary_.CountMessage(channel, time_ns), time_ns, data});
  return chunk_.size() < chunk_bytes_ ? absl::OkStatus() : WriteChunk();
}

absl::Status McapWriter::AddMetadata(absl::string_view name, const Metadata& metadata) {
  McapBytes content;
  content.Add(name).Add(metadata);
  McapBytes record;
  record.AddRecord(McapOpcode::kMetadata, content);
  summary_.AddMetadata(output_.offset(), record.size(), name);
  return output_.Append(record.view());
}

absl::Status McapWriter::WriteChunk() {
  if (!chunk_.has_messages()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const McapBytes index, chunk_.WriteTo(output_));
  summary_.AddChunk(index);
  return absl::OkStatus();
}

absl::Status McapWriter::Finish() {
  RETURN_IF_ERROR(WriteChunk());
  // What no message came behind: a chunk without messages would begin at time 0.
  RETURN_IF_ERROR(output_.Append(chunk_.records()));
  const McapBytes data_crc = McapBytes().Add(output_.crc());
  RETURN_IF_ERROR(output_.Append(McapBytes().AddRecord(McapOpcode::kDataEnd, data_crc).view()));
  RETURN_IF_ERROR(summary_.WriteTo(output_));
  RETURN_IF_ERROR(output_.Append(kMcapMagic));
  return output_.Finish();
}

}  // namespace corbslam::services

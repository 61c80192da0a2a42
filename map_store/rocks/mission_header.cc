#include "map_store/rocks/mission_header.h"

#include "absl/strings/str_cat.h"
#include "map_store/archive/archive.h"
#include "map_store/archive/formats.h"
#include "slam/util/program_version.h"

namespace corbslam::map_store {

absl::StatusOr<uint32_t> CheckFormat(std::string_view bytes, std::string_view written_by) {
  ArchiveReader reader(bytes);
  uint32_t format = 0;
  reader(format);
  if (!reader.done() || format == 0) {
    return absl::DataLossError("its format's number is damaged");
  }
  if (format >= kOldestJournalFormat && format <= kJournalFormat) return format;
  return absl::FailedPreconditionError(absl::StrCat(
      "it has format ", format, ", written by ",
      written_by.empty() ? "a program of an unknown version"
                         : absl::StrCat("version ", std::string(written_by)),
      "; this program is version ", CorbslamVersion(), " and reads ", kOldestJournalFormat, " to ",
      kJournalFormat, format > kJournalFormat ? ": start the newer program" : kHowToReadOlder));
}

std::string EncodeFormat() {
  ArchiveWriter writer;
  writer(kJournalFormat);
  return writer.Take();
}

std::string Encode(const MissionHeader& header) {
  ArchiveWriter writer;
  writer(header.snapshot_position, header.snapshot_bytes);
  return writer.Take();
}

absl::StatusOr<MissionHeader> DecodeHeader(std::string_view bytes) {
  ArchiveReader reader(bytes);
  MissionHeader header;
  reader(header.snapshot_position, header.snapshot_bytes);
  if (reader.done()) return header;
  return absl::DataLossError("a mission's header is damaged");
}

}  // namespace corbslam::map_store

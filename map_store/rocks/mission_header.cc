#include "map_store/rocks/mission_header.h"

#include "map_store/archive/archive.h"

namespace corbslam::map_store {

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

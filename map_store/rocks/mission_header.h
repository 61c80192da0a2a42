// Says what stands under a mission's key in the journal (docs/journal.md).
#ifndef CORBSLAM_MAP_STORE_ROCKS_MISSION_HEADER_H_
#define CORBSLAM_MAP_STORE_ROCKS_MISSION_HEADER_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace corbslam::map_store {

// Returns the format's number as it stands under its key. DATA_LOSS for bytes that are no number,
// FAILED_PRECONDITION for a format that this program doesn't read, with what to do; `written_by` is
// the version of the program that wrote it, if that is known.
absl::StatusOr<uint32_t> CheckFormat(std::string_view bytes, std::string_view written_by = "");
std::string EncodeFormat();

// The position in the header of a mission that is being created: not all of it is
// there yet.
inline constexpr uint64_t kIncomplete = ~uint64_t{0};

struct MissionHeader {
  uint64_t snapshot_position = 0;  // 0: there is none.
  uint64_t snapshot_bytes = 0;
};

std::string Encode(const MissionHeader& header);
// Returns DATA_LOSS for bytes that are no header.
absl::StatusOr<MissionHeader> DecodeHeader(std::string_view bytes);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_MISSION_HEADER_H_

// What stands under a mission's key in the journal (docs/journal.md).
#ifndef CORBSLAM_MAP_STORE_ROCKS_MISSION_HEADER_H_
#define CORBSLAM_MAP_STORE_ROCKS_MISSION_HEADER_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace corbslam::map_store {

// Of the whole journal. Older ones from kOldestJournalFormat on are read and become of this format
// when they are opened, others are refused. 5: without recorded cameras;
// 6: in which no points follow keyframes; 7: in which no features are coded.
inline constexpr uint32_t kOldestJournalFormat = 5;
inline constexpr uint32_t kJournalFormat = 8;

// The position in the header of a mission that is being created: what is there of it is not whole.
inline constexpr uint64_t kNotWhole = ~uint64_t{0};

struct MissionHeader {
  uint64_t snapshot_position = 0;  // 0: there is none.
  uint64_t snapshot_bytes = 0;
};

std::string Encode(const MissionHeader& header);
// DATA_LOSS.
absl::StatusOr<MissionHeader> DecodeHeader(std::string_view bytes);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_MISSION_HEADER_H_

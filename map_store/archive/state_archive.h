// Turns a mission's state to bytes and back. What cameras saw (features: most of the bytes, and
// never changed) is kept apart, by keyframe.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_STATE_ARCHIVE_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_STATE_ARCHIVE_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/records/journal.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Leaves out what ends with the process: sessions, what agents have been sent, words (they are
// computed again) and the keyframe databases.
std::string EncodeState(const MissionState& state);
// Returns a snapshot whose position is not set yet.
JournalSnapshot TakeSnapshot(const MissionState& state);
// Returns DATA_LOSS where the bytes are not what EncodeState made. Goes without features when
// `load` is null (Journal::Replay::with_features), and then believes that the mission is a sound
// one.
absl::StatusOr<MissionState> DecodeState(std::string_view bytes, const FeatureLoader& load);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_STATE_ARCHIVE_H_

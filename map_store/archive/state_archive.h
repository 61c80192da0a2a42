// A mission's state and the records that change it, to bytes and back. What cameras saw (features:
// most of the bytes, and never changed) is kept apart, by keyframe.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_STATE_ARCHIVE_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_STATE_ARCHIVE_H_

#include <functional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "map_store/records/journal.h"
#include "map_store/records/journal_records.h"
#include "map_store/state/mission_state.h"
#include "slam/features/keypoint.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// NOT_FOUND or DATA_LOSS, naming the keyframe.
using FeatureLoader = std::function<absl::StatusOr<Features>(KeyframeId)>;

// Coded (slam/coding/feature_coding.h) where that keeps them to the bit and is shorter, else as
// plain numbers, as journals before format 8 have them all. Each keyframe's can be read alone.
std::string EncodeFeatures(const KeyframePayload& payload);
// All Decode functions: DATA_LOSS where the bytes are not what the Encode function made. Those that
// load features go without when `load` is null (Journal::Replay::with_features), and then believe
// that the bytes are a sound mission's.
absl::StatusOr<Features> DecodeFeatures(std::string_view bytes);

std::string EncodeRecord(const JournalRecord& record);
absl::StatusOr<JournalRecord> DecodeRecord(std::string_view bytes, const FeatureLoader& load);

// Without what ends with the process: sessions, what agents have been sent, words (they are
// computed again) and the keyframe databases.
std::string EncodeState(const MissionState& state);
// With no position yet.
JournalSnapshot TakeSnapshot(const MissionState& state);
absl::StatusOr<MissionState> DecodeState(std::string_view bytes, const FeatureLoader& load);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_STATE_ARCHIVE_H_

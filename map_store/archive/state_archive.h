// Turns a mission's state and the records that change it to bytes and back. What cameras saw
// (features: most of the bytes, and never changed) is kept apart, by keyframe.
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

// Returns a keyframe's features. NOT_FOUND and DATA_LOSS name the keyframe.
using FeatureLoader = std::function<absl::StatusOr<Features>(KeyframeId)>;

// Encodes features: coded (slam/coding/feature_coding.h) where that keeps every bit and is shorter,
// else as plain numbers, as all of them are in journals before format 8. The features of each
// keyframe can be read alone.
std::string EncodeFeatures(const KeyframePayload& payload);
// All Decode functions return DATA_LOSS where the bytes are not what the Encode function made.
// Those that load features go without when `load` is null (Journal::Replay::with_features), and
// then believe that the bytes are a sound mission's.
absl::StatusOr<Features> DecodeFeatures(std::string_view bytes);

// Makes what EncodeRecord writes of a plan.
PlanBytes EncodePlan(const RevisionPlan& plan);
std::string EncodeRecord(const JournalRecord& record);
absl::StatusOr<JournalRecord> DecodeRecord(std::string_view bytes, const FeatureLoader& load);

// Leaves out what ends with the process: sessions, what agents have been sent, words (they are
// computed again) and the keyframe databases.
std::string EncodeState(const MissionState& state);
// Returns a snapshot whose position is not set yet.
JournalSnapshot TakeSnapshot(const MissionState& state);
absl::StatusOr<MissionState> DecodeState(std::string_view bytes, const FeatureLoader& load);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_STATE_ARCHIVE_H_

// Does what journal records do to a mission's state: the same when they are made and when they are
// replayed.
#ifndef CORBSLAM_MAP_STORE_RECORDS_RECORD_APPLICATION_H_
#define CORBSLAM_MAP_STORE_RECORDS_RECORD_APPLICATION_H_

#include "absl/status/status.h"
#include "map_store/fusion/revision.h"
#include "map_store/ingest/batch_application.h"
#include "map_store/options/options.h"
#include "map_store/records/journal_records.h"
#include "map_store/state/mission_state.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::map_store {

// Returns the words of the batch's full keyframes; empty without a vocabulary.
BatchWords ComputeWords(const MapUpdateBatch& batch, const Vocabulary* vocabulary);

void Apply(const BatchRecord& record, const BatchWords& words, const MapStoreOptions& options,
           MissionState& state);
void Apply(const QueryRecord& record, const MapStoreOptions& options, MissionState& state);
// Computes what applying the record next will look up (tables of poses, which the state keeps).
void PrepareToApply(const QueryRecord& record, const MissionState& state);
// Returns whether the record merges islands, or mends what a loop has shown to be wrong: then an
// adjustment of what it touches is due at once.
bool IsUrgent(const FuseRecord& record, const MissionState& state);
// Applies the record and returns whether it was urgent. `layers` are of the record's plan
// (PrepareLayers, TakeLayers), and hold the values from before the record afterwards.
bool Apply(const FuseRecord& record, RevisionLayers& layers, MissionState& state);
void Apply(const FuseRefusedRecord& record, MissionState& state);
void Apply(const AdjustRecord& record, RevisionLayers& layers, MissionState& state);
void Apply(const RederiveRecord& record, MissionState& state);
void Apply(const RetractRecord& record, const MapStoreOptions& options, MissionState& state);
void Apply(const RetireRecord& record, MissionState& state);
void Apply(const JoinRecord& record, MissionState& state);
void Apply(const ForgetRecord& record, MissionState& state);
void Apply(const UidRecord& record, MissionState& state);
void Apply(const ProfileRecord& record, MissionState& state);
void Apply(const LocalisedRecord& record, const MapStoreOptions& options, MissionState& state);

// Leaves local maps whose loops could not be welded to bundle adjustment, which alone has to bring
// the loops in.
void LeaveToAdjustment(const std::vector<LocalMapId>& relaxed, MissionState& state, Island& island);
void Refuse(const std::string& note, OverlapState to, OverlapEntry& entry);

// Returns DATA_LOSS where a record read from a journal names what the state does not have (records
// before it are missing), or holds what no store would have written.
absl::Status CheckReplay(const JournalRecord& record, const MissionState& state);

// Computes what a snapshot leaves out: words and keyframe databases.
void RestoreWords(const Vocabulary* vocabulary, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_RECORD_APPLICATION_H_

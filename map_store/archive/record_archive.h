// Turns the records that change a mission's state to bytes and back.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_RECORD_ARCHIVE_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_RECORD_ARCHIVE_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/records/journal_records.h"

namespace corbslam::map_store {

// Makes what EncodeRecord writes of a plan.
PlanBytes EncodePlan(const RevisionPlan& plan);
// Leaves out features.
std::string EncodeRecord(const JournalRecord& record);
// Returns DATA_LOSS where the bytes are not what EncodeRecord made, or what `load` returns. Goes
// without features when `load` is null (Journal::Replay::with_features).
absl::StatusOr<JournalRecord> DecodeRecord(std::string_view bytes, const FeatureLoader& load);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_RECORD_ARCHIVE_H_

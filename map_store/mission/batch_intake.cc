#include "map_store/mission/batch_intake.h"

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/ingest/gone_local_maps.h"
#include "map_store/ingest/mission_limits.h"
#include "map_store/ingest/quota.h"
#include "map_store/mission/mission_sessions.h"
#include "map_store/mission/room_check.h"
#include "map_store/mission/transfer_statistics.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::StatusOr<std::optional<Acknowledgement>> CheckNumber(const MissionState& state,
                                                           const MapUpdateBatch& batch) {
  const uint64_t last = LastBatchOf(state, batch.local_map);
  if (batch.number == 0) return absl::InvalidArgumentError("batch without a number");
  if (batch.number <= last) return Acknowledgement{batch.local_map, last};
  RETURN_IF_ERROR(CheckTakesBatches(state, batch.local_map));
  if (batch.number == last + 1) return std::nullopt;
  return absl::FailedPreconditionError(absl::StrCat("batch ", batch.number, " of local map ",
                                                    ToString(batch.local_map), ": expected ",
                                                    last + 1));
}

}  // namespace

absl::StatusOr<BatchIntake::Known> BatchIntake::Check(uint64_t session_id, const std::string& agent,
                                                      const MapUpdateBatch& batch) const {
  RETURN_IF_ERROR(CheckSession(strand_, session_id, agent));
  const MissionState& state = strand_.state();
  if (state.agents.at(agent).localise_only) {
    return absl::PermissionDeniedError(
        absl::StrCat("agent ", agent,
                     " opened its session with localise_only, which changes nothing: it may not "
                     "send batches"));
  }
  const LocalMapState* local_map = state.FindLocalMap(batch.local_map);
  if (local_map != nullptr && local_map->agent != agent) {
    return absl::PermissionDeniedError(
        absl::StrCat("local map ", ToString(batch.local_map), " is another agent's"));
  }
  ASSIGN_OR_RETURN(const Known known, CheckNumber(state, batch));
  if (known.has_value()) return known;
  if (local_map == nullptr) RETURN_IF_ERROR(CheckRoomForLocalMap(state, strand_.options()));
  RETURN_IF_ERROR(CheckQuota(state, agent, batch, strand_.options()));
  RETURN_IF_ERROR(CheckKeyframeLimits(state, agent, batch));
  return known;
}

absl::StatusOr<BatchIntake::Known> BatchIntake::CheckAndValidate(
    uint64_t session_id, const std::string& agent, const MapUpdateBatch& batch) const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  ASSIGN_OR_RETURN(const Known known, Check(session_id, agent, batch));
  if (known.has_value()) return known;
  RETURN_IF_ERROR(
      ValidateBatch(strand_.state().FindLocalMap(batch.local_map), batch, strand_.options()));
  RETURN_IF_ERROR(CheckMemoryLimit(strand_.state(), batch));
  return known;
}

absl::StatusOr<BatchIntake::Applied> BatchIntake::ApplyInTurn(uint64_t session_id,
                                                              const BatchRecord& record,
                                                              const BatchWords& words) {
  absl::MutexLock turn(&strand_.turn());
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    ASSIGN_OR_RETURN(const Known known, Check(session_id, record.agent, *record.batch));
    if (known.has_value()) return Applied{.known = known};
  }
  RETURN_IF_ERROR(strand_.Append(record));
  Applied applied;
  {
    StateWriteLock lock(strand_);
    map_store::Apply(record, words, strand_.options(), strand_.mutable_state());
    // Once the turn is over somebody may have the local map forgotten.
    const MapUpdateBatch& batch = *record.batch;
    const LocalMapState* local_map = strand_.state().FindLocalMap(batch.local_map);
    applied.begins = local_map != nullptr && !batch.full_keyframes.empty() &&
                     local_map->arrived.size() <= batch.full_keyframes.size();
  }
  NoteEvents(record);
  return applied;
}

void BatchIntake::NoteEvents(const BatchRecord& record) {
  const MapUpdateBatch& batch = *record.batch;
  const uint64_t revision = strand_.state_in_turn().global.revision;
  if (batch.number == 1) {
    events_.Note(revision, MissionEvent::LocalMapBegun{batch.local_map, record.agent});
  }
  const size_t lost = batch.lost_frames_ns.size();
  if (lost == 0) {
    lost_.erase(record.agent);
    return;
  }
  // While it stays lost, that is no news; it would drive all else out of the book.
  if (!lost_.insert(record.agent).second) return;
  events_.Note(revision, MissionEvent::TrackingLost{batch.local_map, record.agent, lost});
}

BatchRecord BatchIntake::MakeRecord(const std::string& agent, const MapUpdateBatch& batch) const {
  BatchRecord record{agent, nullptr, strand_.environment().clock()};
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    record.batch = WithoutKnownKeyframes(batch, strand_.state().FindLocalMap(batch.local_map));
  }
  strand_.environment().journal->Prepare(record);
  return record;
}

// What the store keeps of a batch takes about twice its bytes: words, indices, tables.
absl::StatusOr<Acknowledgement> BatchIntake::Apply(uint64_t session_id, const std::string& agent,
                                                   const MapUpdateBatch& batch,
                                                   const BatchTransfer* measured) {
  const absl::Time begin = strand_.environment().clock();
  Applied applied;
  ASSIGN_OR_RETURN(applied.known, CheckAndValidate(session_id, agent, batch));
  if (!applied.known.has_value()) {
    const uint64_t bytes = StoredBytes(batch);
    RETURN_IF_ERROR(CheckRoom(strand_, NameOfBatch(batch), 2 * bytes, bytes));
    const BatchWords words = ComputeWords(batch, strand_.environment().vocabulary);
    ASSIGN_OR_RETURN(applied, ApplyInTurn(session_id, MakeRecord(agent, batch), words));
  }
  // A batch that came again may not be durable yet.
  if (applied.known.has_value()) {
    RETURN_IF_ERROR(strand_.Sync());
    return *applied.known;
  }
  {
    const BatchTransfer transfer = measured != nullptr ? *measured : EstimateTransfer(batch);
    StateWriteLock lock(strand_);
    CountTransfer(batch, transfer,
                  absl::ToDoubleMilliseconds(strand_.environment().clock() - begin),
                  strand_.mutable_state().statistics);
  }
  // Others' batches become durable together with this one.
  const absl::Status durable = strand_.Sync();
  strand_.environment().wake_fusion();
  listeners_.CallAllBut(session_id);
  events_.Tell();
  RETURN_IF_ERROR(durable);
  // With its first keyframe a local map may have a place in the global frame, which its owner is
  // told.
  if (applied.begins) listeners_.Call(session_id);
  return Acknowledgement{batch.local_map, batch.number};
}

}  // namespace corbslam::map_store

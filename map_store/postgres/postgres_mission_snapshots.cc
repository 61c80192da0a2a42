// Implements the part of PostgresMission that writes whole states. Their pieces come first, where
// nobody looks for them yet; a last, small transaction puts them in the records' place.
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/postgres/pieces.h"
#include "map_store/postgres/postgres_mission.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Pieces of one transaction.
constexpr size_t kPiecesAtOnce = 16;
// Bytes of features of one transaction, about.
constexpr uint64_t kFeaturesAtOnce = 8 << 20;
// Of a mission that was made elsewhere.
constexpr Journal::Position kFirstPosition = 1;

}  // namespace

absl::Status PostgresMission::WritePieces(absl::string_view state, int64_t generation) {
  SqlStatements statements;
  for (const Piece& piece :
       CutPieces({state.data(), state.size()}, static_cast<uint64_t>(generation))) {
    statements.push_back(
        {"INSERT INTO corbslam.snapshots (mission_id, generation, piece, pieces, checksum, bytes)"
         " VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT DO NOTHING",
         {Id(), SqlValue::Number(generation), SqlValue::Bits(piece.number),
          SqlValue::Bits(piece.count), SqlValue::Bits(piece.checksum),
          SqlValue::Bytes(std::string(piece.bytes))}});
    if (statements.size() < kPiecesAtOnce && piece.number + 1 < piece.count) continue;
    RETURN_IF_ERROR(pool_.WriteAgain(statements).status());
    statements.clear();
  }
  return absl::OkStatus();
}

void PostgresMission::DropPieces(int64_t generation) {
  // The turn may have been done before its answer was lost.
  pool_
      .WriteAgain({{"DELETE FROM corbslam.snapshots WHERE mission_id = $1 AND generation = $2"
                    " AND NOT EXISTS (SELECT 1 FROM corbslam.missions WHERE mission_id = $1"
                    " AND snapshot_generation = $2)",
                    {Id(), SqlValue::Number(generation)}}})
      .status()
      .IgnoreError();
}

SqlOutcome PostgresMission::Turn(SqlConnection& connection, const JournalSnapshot& snapshot,
                                 int64_t generation, const SqlStatements& drops) {
  const absl::StatusOr<MissionRow> row = LockMissionRow(connection, id_);
  if (absl::IsNotFound(row.status())) {
    return {absl::FailedPreconditionError("another process has deleted it")};
  }
  if (!row.ok()) return {row.status()};
  absl::Status turn;
  {
    absl::MutexLock lock(&mutex_);
    turn = CheckTurn(*row);
  }
  if (!turn.ok()) {
    connection.Rollback();
    return {turn};
  }
  SqlStatements statements = {
      {"UPDATE corbslam.missions SET snapshot_position = $2, snapshot_generation = $3,"
       " snapshot_bytes = $4 WHERE mission_id = $1",
       {Id(), SqlValue::Bits(snapshot.position), SqlValue::Number(generation),
        SqlValue::Bits(snapshot.state.size())}},
      {"DELETE FROM corbslam.records WHERE mission_id = $1 AND position <= $2",
       {Id(), SqlValue::Bits(snapshot.position)}},
      {"DELETE FROM corbslam.snapshots WHERE mission_id = $1 AND generation <> $2",
       {Id(), SqlValue::Number(generation)}}};
  statements.insert(statements.end(), drops.begin(), drops.end());
  return connection.Commit(std::move(statements));
}

absl::Status PostgresMission::WriteSnapshot(const JournalSnapshot& snapshot) {
  RETURN_IF_ERROR(EnsureLoaded());
  RETURN_IF_ERROR(FlushAll());
  const int64_t generation = DrawRowId();
  RETURN_IF_ERROR(Name(WritePieces(snapshot.state, generation)));
  std::vector<KeyframeId> unneeded;
  std::vector<BookedPicture> gone;
  {
    absl::MutexLock lock(&mutex_);
    RETURN_IF_ERROR(CheckOpen());
    unneeded = contents_.FindUnneeded(snapshot);
    gone = pictures_.FindUnneeded(snapshot.position,
                                  {snapshot.keyframes.begin(), snapshot.keyframes.end()});
  }
  SqlStatements drops;
  for (const KeyframeId& id : unneeded) {
    drops.push_back(
        {"DELETE FROM corbslam.keyframes WHERE mission_id = $1 AND local_map = $2"
         " AND keyframe = $3 AND position <= $4",
         {Id(), SqlValue::Bits(id.local_map.value), SqlValue::Number(id.index),
          SqlValue::Bits(snapshot.position)}});
  }
  if (!unneeded.empty()) drops.push_back(DropUnusedPayloads());
  AddPictureRemovals(gone, drops);
  const SqlOutcome outcome = pool_.Try(
      [&](SqlConnection& connection) { return Turn(connection, snapshot, generation, drops); });
  if (absl::IsFailedPrecondition(outcome.status)) DropPieces(generation);
  RETURN_IF_ERROR(Name(outcome.status));
  absl::MutexLock lock(&mutex_);
  contents_.NoteSnapshot(snapshot.position, snapshot.state.size(), unneeded);
  for (const BookedPicture& picture : gone) pictures_.Take(picture.keyframe);
  return absl::OkStatus();
}

absl::Status PostgresMission::WriteFeatures(const MissionState& state) {
  SqlStatements statements;
  uint64_t bytes = 0;
  for (const auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      const std::string features = EncodeFeatures(*keyframe.payload);
      AddFeatures(keyframe_id, features, kFirstPosition, statements);
      bytes += features.size();
      {
        absl::MutexLock lock(&mutex_);
        contents_.NoteFeatures(keyframe_id, kFirstPosition, features.size());
      }
      if (bytes < kFeaturesAtOnce) continue;
      RETURN_IF_ERROR(pool_.WriteAgain(std::exchange(statements, {})).status());
      bytes = 0;
    }
  }
  return statements.empty() ? absl::OkStatus() : pool_.WriteAgain(statements).status();
}

absl::Status PostgresMission::WriteNewMission(const MissionState& state) {
  RETURN_IF_ERROR(
      pool_.WriteAgain({InsertMissionRow(id_, nullptr, MissionStage::kBeingMade, holder_)})
          .status());
  RETURN_IF_ERROR(WriteFeatures(state));
  const JournalSnapshot snapshot = TakeSnapshot(state);
  const int64_t generation = DrawRowId();
  RETURN_IF_ERROR(WritePieces(snapshot.state, generation));
  RETURN_IF_ERROR(
      pool_
          .WriteAgain(
              {{"UPDATE corbslam.missions SET name = $2, state = 0, head = $3, head_group = $4,"
                " snapshot_position = $3, snapshot_generation = $4, snapshot_bytes = $5,"
                " lease_until = CASE WHEN $6 > 0"
                " THEN clock_timestamp() + $6 * interval '1 millisecond' END"
                " WHERE mission_id = $1",
                {Id(), SqlValue::Text(name_), SqlValue::Bits(kFirstPosition),
                 SqlValue::Number(generation), SqlValue::Bits(snapshot.state.size()),
                 holder_.LeaseMilliseconds()}}})
          .status());
  absl::MutexLock lock(&mutex_);
  is_made_ = true;
  head_ = last_ = synced_ = kFirstPosition;
  head_group_ = generation;
  contents_.NoteSnapshot(kFirstPosition, snapshot.state.size(), {});
  return absl::OkStatus();
}

absl::Status PostgresMission::Create(const MissionState& state) {
  const absl::Status made = Name(WriteNewMission(state));
  if (made.ok()) return made;
  // What is left, should this fail, goes in time: nobody finds it without a name.
  DeleteRow(0).IgnoreError();
  return made;
}

}  // namespace corbslam::map_store

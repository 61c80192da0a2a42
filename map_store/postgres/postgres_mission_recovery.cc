// Implements the part of PostgresMission that reads what is in the database.
#include <algorithm>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "map_store/archive/formats.h"
#include "map_store/archive/record_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/postgres/feature_reader.h"
#include "map_store/postgres/pieces.h"
#include "map_store/postgres/postgres_mission.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// More than any number of a piece.
constexpr uint64_t kBehindAllPieces = uint64_t{1} << 62;

absl::Status AtPlace(const absl::Status& status, const std::string& place) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(place, ": ", status.message()));
}

absl::Status CheckRowFormat(int64_t format) {
  if (format >= int64_t{kOldestJournalFormat} && format <= int64_t{kJournalFormat}) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat("it has format ", format, ", and this program ",
                                                    "reads ", kOldestJournalFormat, " to ",
                                                    kJournalFormat));
}

// Columns: piece, pieces, checksum, bytes, from `column` on.
Piece PieceOf(const SqlResult& rows, int row, int column) {
  return {rows.Bits(row, column), rows.Bits(row, column + 1), rows.Bits(row, column + 2),
          rows.Bytes(row, column + 3)};
}

// Returns null where the replay wants no features.
FeatureLoader MakeLoader(const Journal::Replay& replay, FeatureReader* reader) {
  if (!replay.with_features) return nullptr;
  return [reader](KeyframeId id) { return reader->Read(id); };
}

}  // namespace

absl::Status PostgresMission::EnsureLoaded(bool wakes) {
  {
    absl::MutexLock lock(&mutex_);
    if (!damage_.ok()) return damage_;
    if (is_aside_ && !wakes) return CheckOpen();
    if (is_loaded_ && !is_aside_) return absl::OkStatus();
    if (holder_.lease > absl::ZeroDuration() && !wakes) {
      return Name(absl::FailedPreconditionError("this process does not have it"));
    }
  }
  absl::MutexLock loading(&loading_);
  {
    absl::MutexLock lock(&mutex_);
    if (is_loaded_ && !is_aside_) return absl::OkStatus();
  }
  return Note(Load());
}

absl::Status PostgresMission::Load() {
  // What waits since it was put aside; in vain, if another process has the mission.
  const absl::Status flushed = FlushAll();
  if (!flushed.ok() && !absl::IsFailedPrecondition(flushed)) return flushed;
  ASSIGN_OR_RETURN(const MissionRow row, TakeOver());
  {
    absl::MutexLock lock(&mutex_);
    epoch_ = row.epoch;
    head_ = synced_ = last_ = row.head;
    head_group_ = row.head_group;
    waiting_.clear();
    waiting_bytes_ = 0;
    unknown_.reset();
    failure_ = absl::OkStatus();
    contents_ = MissionContents();
    pictures_ = PictureBook();
    contents_.NoteSnapshot(row.snapshot_position, row.snapshot_bytes, {});
  }
  RETURN_IF_ERROR(LoadContents(row));
  absl::MutexLock lock(&mutex_);
  is_loaded_ = true;
  is_aside_ = false;
  return absl::OkStatus();
}

absl::Status PostgresMission::CheckHeld(const MissionRow& row) const {
  if (MayTake(row.holding(), holder_.id)) return absl::OkStatus();
  return WithElsewhere(absl::UnavailableError(absl::StrCat("another process (", row.holder_name,
                                                           ") holds it for another ",
                                                           absl::FormatDuration(row.lease_left))),
                       row.holder_address);
}

absl::StatusOr<MissionRow> PostgresMission::TakeOver() {
  MissionRow row;
  const SqlOutcome outcome = pool_.Try([&](SqlConnection& connection) -> SqlOutcome {
    const absl::StatusOr<MissionRow> locked = LockMissionRow(connection, id_);
    if (absl::IsNotFound(locked.status())) {
      return {absl::FailedPreconditionError("another process has deleted it")};
    }
    if (!locked.ok()) return {locked.status()};
    row = *locked;
    absl::Status mine = CheckRowFormat(row.format);
    mine.Update(CheckHeld(row));
    if (!mine.ok()) {
      connection.Rollback();
      return {mine};
    }
    ++row.epoch;
    // Once this lasts, so does all that is read afterwards.
    return connection.Commit(
        {{"UPDATE corbslam.missions SET epoch = $2, format = $3, state = 0, summary = NULL,"
          " summary_checksum = NULL, holder = $4, holder_name = $5, wanted_store = NULL,"
          " lease_until ="
          " CASE WHEN $6 > 0 THEN clock_timestamp() + $6 * interval '1 millisecond' END"
          " WHERE mission_id = $1",
          {Id(), SqlValue::Number(row.epoch), SqlValue::Number(kJournalFormat),
           SqlValue::Number(holder_.id), SqlValue::Text(holder_.name),
           holder_.LeaseMilliseconds()}}});
  });
  RETURN_IF_ERROR(outcome.status);
  return row;
}

absl::Status PostgresMission::LoadContents(const MissionRow& row) {
  ASSIGN_OR_RETURN(
      const std::vector<SqlResult> read,
      pool_.Read({{"SELECT position, sum(octet_length(bytes))::bigint FROM corbslam.records"
                   " WHERE mission_id = $1 AND position > $2 GROUP BY position",
                   {Id(), SqlValue::Bits(row.snapshot_position)}},
                  {"SELECT local_map, keyframe, position, size FROM corbslam.keyframes"
                   " WHERE mission_id = $1",
                   {Id()}},
                  {"SELECT local_map, keyframe, ordinal, size FROM corbslam.pictures"
                   " WHERE mission_id = $1",
                   {Id()}}}));
  const auto keyframe_of = [](const SqlResult& rows, int i) {
    return KeyframeId{{rows.Bits(i, 0)}, static_cast<uint32_t>(rows.Number(i, 1))};
  };
  absl::MutexLock lock(&mutex_);
  for (int i = 0; i < read[0].rows(); ++i) {
    contents_.NoteRecord(read[0].Bits(i, 0), read[0].Bits(i, 1));
  }
  for (int i = 0; i < read[1].rows(); ++i) {
    contents_.NoteFeatures(keyframe_of(read[1], i), read[1].Bits(i, 2), read[1].Bits(i, 3));
  }
  for (int i = 0; i < read[2].rows(); ++i) {
    pictures_.Put({read[2].Bits(i, 2), keyframe_of(read[2], i), read[2].Bits(i, 3), row.head});
  }
  return absl::OkStatus();
}

absl::StatusOr<Journal::Position> PostgresMission::Recover(const Journal::Replay& replay) {
  RETURN_IF_ERROR(EnsureLoaded(true));
  RETURN_IF_ERROR(FlushAll());
  {
    absl::MutexLock lock(&mutex_);
    if (!is_made_) return 0;
  }
  Position position = 0;
  Journal::Replay noting = replay;
  noting.on_record = [this, &replay, &position](const JournalRecord& record) {
    RETURN_IF_ERROR(replay.on_record(record));
    absl::MutexLock lock(&mutex_);
    for (const KeyframeId& id : RemovedBy(record)) contents_.NoteRemoved(id, position);
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(Note(ReplayAll(noting, position)));
  return position;
}

absl::Status PostgresMission::ReplayAll(const Journal::Replay& replay, Position& position) const {
  ASSIGN_OR_RETURN(const std::vector<SqlResult> read, pool_.Read({SelectMissionRow(id_)}));
  const absl::StatusOr<MissionRow> row = MissionRowOf(read.front());
  if (!row.ok()) return absl::FailedPreconditionError("another process has deleted it");
  position = row->snapshot_position;
  if (row->snapshot_generation != 0) {
    RETURN_IF_ERROR(AtPlace(ReplaySnapshot(*row, replay), absl::StrCat("snapshot ", position)));
  }
  return ReplayRecords(*row, replay, position);
}

absl::Status PostgresMission::ReplaySnapshot(const MissionRow& row,
                                             const Journal::Replay& replay) const {
  const auto place = static_cast<uint64_t>(row.snapshot_generation);
  PieceJoiner joiner;
  for (uint64_t next = 0; !joiner.is_whole();) {
    ASSIGN_OR_RETURN(
        const std::vector<SqlResult> read,
        pool_.Read({{"SELECT piece, pieces, checksum, bytes FROM corbslam.snapshots"
                     " WHERE mission_id = $1 AND generation = $2 AND piece >= $3"
                     " ORDER BY piece LIMIT 32",
                     {Id(), SqlValue::Number(row.snapshot_generation), SqlValue::Bits(next)}}}));
    const SqlResult& rows = read.front();
    if (rows.rows() == 0) return absl::DataLossError(absl::StrCat("piece ", next, " is lost"));
    for (int i = 0; i < rows.rows(); ++i, ++next) {
      RETURN_IF_ERROR(joiner.Add(PieceOf(rows, i, 0), place));
    }
  }
  FeatureReader reader(pool_, id_);
  ASSIGN_OR_RETURN(MissionState state, DecodeState(joiner.Take(), MakeLoader(replay, &reader)));
  return replay.on_snapshot(std::move(state));
}

absl::Status PostgresMission::ReplayRecords(const MissionRow& row, const Journal::Replay& replay,
                                            Position& position) const {
  const Position end = std::min(replay.until, row.head);
  FeatureReader reader(pool_, id_);
  const FeatureLoader load = MakeLoader(replay, &reader);
  PieceJoiner joiner;
  Position last = position;
  uint64_t last_piece = kBehindAllPieces;
  while (position < end) {
    ASSIGN_OR_RETURN(
        const std::vector<SqlResult> read,
        pool_.Read(
            {{"SELECT position, piece, pieces, checksum, bytes FROM corbslam.records"
              " WHERE mission_id = $1 AND (position, piece) > ($2, $3) AND position <= $4"
              " ORDER BY position, piece LIMIT 128",
              {Id(), SqlValue::Bits(last), SqlValue::Bits(last_piece), SqlValue::Bits(end)}}}));
    const SqlResult& rows = read.front();
    const std::string place = absl::StrCat("record ", position + 1);
    if (rows.rows() == 0) return absl::DataLossError(place + " is lost");
    for (int i = 0; i < rows.rows(); ++i) {
      last = rows.Bits(i, 0);
      last_piece = rows.Bits(i, 1);
      RETURN_IF_ERROR(ReplayPiece(PieceOf(rows, i, 1), last, replay, load, joiner, position));
    }
  }
  return absl::OkStatus();
}

absl::Status PostgresMission::ReplayPiece(const Piece& piece, Position of,
                                          const Journal::Replay& replay, const FeatureLoader& load,
                                          PieceJoiner& joiner, Position& position) {
  const std::string place = absl::StrCat("record ", position + 1);
  if (of != position + 1) return absl::DataLossError(place + " is lost, or a part of it");
  RETURN_IF_ERROR(AtPlace(joiner.Add(piece, of), place));
  if (!joiner.is_whole()) return absl::OkStatus();
  const absl::StatusOr<JournalRecord> record = DecodeRecord(joiner.Take(), load);
  RETURN_IF_ERROR(AtPlace(record.status(), place));
  ++position;
  return AtPlace(replay.on_record(*record), place);
}

}  // namespace corbslam::map_store

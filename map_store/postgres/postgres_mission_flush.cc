// Implements the part of PostgresMission that appends. A group of records is one transaction, and
// ends in one of three ways: it is there, it is not there, or nobody knows. What nobody knows is
// found out by the next transaction, which waits for the row and sees where the mission stands.
#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/archive/batch_bytes.h"
#include "map_store/postgres/content_hash.h"
#include "map_store/postgres/pieces.h"
#include "map_store/postgres/postgres_mission.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// One transaction takes about so many bytes.
constexpr uint64_t kGroupBytes = 8 << 20;
// With more, whoever appends waits.
constexpr uint64_t kMostWaitingBytes = 32 << 20;
// A server that has failed is left alone for so long by those who append.
constexpr absl::Duration kBetweenAttempts = absl::Seconds(1);

}  // namespace

absl::StatusOr<Journal::Position> PostgresMission::Append(std::shared_ptr<const BatchBytes> bytes,
                                                          const std::vector<KeyframeId>& removed) {
  RETURN_IF_ERROR(EnsureLoaded());
  bool must_flush = false;
  {
    absl::MutexLock lock(&mutex_);
    RETURN_IF_ERROR(CheckOpen());
    const bool is_lasting = absl::IsFailedPrecondition(failure_);
    if (is_lasting || absl::Now() < failed_at_ + kBetweenAttempts) RETURN_IF_ERROR(failure_);
    must_flush = !failure_.ok() || waiting_bytes_ > kMostWaitingBytes;
  }
  if (must_flush) RETURN_IF_ERROR(FlushAll());
  absl::MutexLock lock(&mutex_);
  RETURN_IF_ERROR(CheckOpen());
  Waiting waiting{++last_, std::move(bytes), {}, absl::Now()};
  contents_.NoteRecord(last_, waiting.bytes->record.size());
  for (const auto& [id, features] : waiting.bytes->features) {
    contents_.NoteFeatures(id, last_, features.size());
  }
  for (const KeyframeId& id : removed) {
    contents_.NoteRemoved(id, last_);
    if (const auto picture = pictures_.Take(id)) waiting.gone.push_back(*picture);
  }
  waiting_bytes_ += SizeOf(*waiting.bytes);
  waiting_.push_back(std::move(waiting));
  return last_;
}

absl::Status PostgresMission::Sync(Position position) {
  {
    absl::MutexLock lock(&mutex_);
    if (!is_loaded_ && !is_aside_) return damage_;
    // A position of an earlier mission of the name may be larger than all of this one's.
    position = std::min(position, last_);
    if (position <= synced_) return absl::OkStatus();
    if (is_deleted_) return CheckOpen();
  }
  return Flush(position);
}

absl::Status PostgresMission::FlushOlderThan(absl::Time then) {
  {
    absl::MutexLock lock(&mutex_);
    if (is_deleted_ || waiting_.empty() || waiting_.front().since > then) return absl::OkStatus();
  }
  return FlushAll();
}

absl::Status PostgresMission::FlushAll() {
  Position last = 0;
  {
    absl::MutexLock lock(&mutex_);
    last = last_;
  }
  return Flush(last);
}

absl::Status PostgresMission::Flush(Position position) {
  absl::MutexLock lock(&mutex_);
  const uint64_t failures = failures_;
  while (synced_ < position) {
    if (absl::IsFailedPrecondition(failure_)) return failure_;
    if (is_deleted_) return CheckOpen();
    if (is_flushing_) {
      flushed_.Wait(&mutex_);
      // The attempt of another one serves all who waited for it.
      if (failures_ != failures && synced_ < position) return failure_;
      continue;
    }
    is_flushing_ = true;
    mutex_.Unlock();
    const SqlOutcome outcome =
        pool_.Try([this](SqlConnection& connection) { return WriteGroup(connection); });
    mutex_.Lock();
    is_flushing_ = false;
    failure_ = Name(outcome.status);
    if (absl::IsFailedPrecondition(failure_)) ++*holder_.refused;
    if (!failure_.ok()) {
      ++failures_;
      failed_at_ = absl::Now();
    } else {
      failed_at_ = absl::InfinitePast();
    }
    flushed_.SignalAll();
    RETURN_IF_ERROR(failure_);
  }
  return absl::OkStatus();
}

SqlOutcome PostgresMission::WriteGroup(SqlConnection& connection) {
  SqlStatements before;
  {
    absl::MutexLock lock(&mutex_);
    if (!is_made_) before.push_back(InsertMissionRow(id_, &name_, MissionStage::kInUse, holder_));
  }
  const absl::StatusOr<MissionRow> row = LockMissionRow(connection, id_, before);
  if (absl::IsNotFound(row.status())) {
    return {absl::FailedPreconditionError("another process has deleted it, or made its like")};
  }
  if (!row.ok()) return {row.status()};
  Group group;
  absl::Status settled;
  {
    absl::MutexLock lock(&mutex_);
    settled = Settle(*row);
    group = TakeGroup();
  }
  if (!settled.ok()) {
    connection.Rollback();
    return {settled};
  }
  const SqlOutcome outcome = connection.Commit(StatementsOf(group));
  absl::MutexLock lock(&mutex_);
  if (outcome.status.ok()) {
    NoteCommitted(group.last, group.id);
    synced_ = head_;
  } else if (outcome.is_unknown) {
    unknown_ = std::move(group);
  }
  return outcome;
}

absl::Status PostgresMission::CheckTurn(const MissionRow& row) const {
  if (row.stage == MissionStage::kDeleted) {
    return absl::FailedPreconditionError("another process has deleted it");
  }
  if (MayWrite(row.holding(), epoch_)) return absl::OkStatus();
  return WithElsewhere(
      absl::FailedPreconditionError(absl::StrCat(
          "another process (", row.holder_name, ") has taken it over, in epoch ", row.epoch,
          "; this one had it in epoch ", epoch_, " and writes nothing more")),
      row.holder_address);
}

absl::Status PostgresMission::Settle(const MissionRow& row) {
  RETURN_IF_ERROR(CheckTurn(row));
  const std::optional<Group> unknown = std::exchange(unknown_, std::nullopt);
  if (unknown.has_value() && row.head_group == unknown->id && row.head == unknown->last) {
    // It is there, and lasts once the transaction that is open now does.
    NoteCommitted(unknown->last, unknown->id);
  }
  if (row.head == head_ && row.head_group == head_group_) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("its last record is ", row.head, ", and this process has written ", head_,
                   ": the database was restored from a backup, or another process writes into it"));
}

void PostgresMission::NoteCommitted(Position last, int64_t group) {
  is_made_ = true;
  head_ = last;
  head_group_ = group;
  while (!waiting_.empty() && waiting_.front().position <= last) {
    waiting_bytes_ -= SizeOf(*waiting_.front().bytes);
    waiting_.pop_front();
  }
}

PostgresMission::Group PostgresMission::TakeGroup() const {
  Group group{DrawRowId(), head_, {}, contents_.live_bytes() + pictures_.bytes()};
  uint64_t bytes = 0;
  for (const Waiting& waiting : waiting_) {
    bytes += SizeOf(*waiting.bytes);
    if (!group.records.empty() && bytes > kGroupBytes) break;
    group.records.push_back(waiting);
    group.last = waiting.position;
  }
  return group;
}

void PostgresMission::AddFeatures(KeyframeId id, absl::string_view features, Position position,
                                  SqlStatements& statements) const {
  const std::string hash = ContentHash(features);
  for (const Piece& piece : CutPieces({features.data(), features.size()}, 0)) {
    statements.push_back(
        {"INSERT INTO corbslam.payloads (mission_id, hash, piece, bytes) VALUES ($1, $2, $3, $4)"
         " ON CONFLICT DO NOTHING",
         {Id(), SqlValue::Bytes(hash), SqlValue::Bits(piece.number),
          SqlValue::Bytes(std::string(piece.bytes))}});
  }
  statements.push_back(
      {"INSERT INTO corbslam.keyframes (mission_id, local_map, keyframe, position, hash, size)"
       " VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (mission_id, local_map, keyframe)"
       " DO UPDATE SET position = excluded.position, hash = excluded.hash, size = excluded.size",
       {Id(), SqlValue::Bits(id.local_map.value), SqlValue::Number(id.index),
        SqlValue::Bits(position), SqlValue::Bytes(hash), SqlValue::Bits(features.size())}});
}

SqlStatements PostgresMission::StatementsOf(const Group& group) const {
  SqlStatements statements;
  for (const Waiting& record : group.records) {
    for (const Piece& piece : CutPieces(record.bytes->record, record.position)) {
      statements.push_back(
          {"INSERT INTO corbslam.records (mission_id, position, piece, pieces, checksum, bytes)"
           " VALUES ($1, $2, $3, $4, $5, $6)",
           {Id(), SqlValue::Bits(record.position), SqlValue::Bits(piece.number),
            SqlValue::Bits(piece.count), SqlValue::Bits(piece.checksum),
            SqlValue::Bytes(std::string(piece.bytes))}});
    }
    for (const auto& [id, features] : record.bytes->features) {
      AddFeatures(id, features, record.position, statements);
    }
    AddPictureRemovals(record.gone, statements);
  }
  statements.push_back(
      {"UPDATE corbslam.missions SET head = $2, head_group = $3, bytes = $4, lease_until ="
       " CASE WHEN $5 > 0 THEN clock_timestamp() + $5 * interval '1 millisecond' END"
       " WHERE mission_id = $1",
       {Id(), SqlValue::Bits(group.last), SqlValue::Number(group.id),
        SqlValue::Bits(group.mission_bytes), holder_.LeaseMilliseconds()}});
  return statements;
}

}  // namespace corbslam::map_store

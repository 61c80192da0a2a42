#include "map_store/postgres/postgres_mission.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

PostgresMission::PostgresMission(std::string name, const PostgresJournalOptions& options,
                                 SqlPool* pool, const MissionHolder& holder, const Known& known)
    : name_(std::move(name)),
      options_(options),
      pool_(*pool),
      holder_(holder),
      id_(known.id),
      is_loaded_(!known.is_made),
      is_made_(known.is_made),
      is_aside_(known.is_aside),
      bytes_aside_(known.bytes) {}

absl::Status PostgresMission::Name(const absl::Status& error) const {
  if (error.ok()) return error;
  const std::string name = absl::StrCat(pool_.name(), ": ");
  std::string message(error.message());
  if (message.compare(0, name.size(), name) == 0) message.erase(0, name.size());
  return WithMessage(error, absl::StrCat(pool_.name(), ", mission ", name_, ": ", message));
}

absl::Status PostgresMission::Note(const absl::Status& error) {
  const absl::Status named = Name(error);
  absl::MutexLock lock(&mutex_);
  if (absl::IsDataLoss(named) && damage_.ok()) damage_ = named;
  return named;
}

absl::Status PostgresMission::Damage() const {
  absl::MutexLock lock(&mutex_);
  return damage_;
}

absl::Status PostgresMission::CheckOpen() const {
  if (!damage_.ok()) return damage_;
  if (is_deleted_) return Name(absl::UnavailableError("it is deleted"));
  if (is_aside_) return Name(absl::UnavailableError("it is closed, as nobody used it"));
  return absl::OkStatus();
}

uint64_t PostgresMission::DiskBytes() const {
  absl::MutexLock lock(&mutex_);
  return is_loaded_ ? contents_.live_bytes() + pictures_.bytes() : bytes_aside_;
}

bool PostgresMission::WantsSnapshot() const {
  absl::MutexLock lock(&mutex_);
  return is_loaded_ && CheckOpen().ok() &&
         contents_.WantsSnapshot(options_.min_bytes_between_snapshots);
}

absl::Status PostgresMission::PutAside(absl::string_view summary) {
  RETURN_IF_ERROR(EnsureLoaded());
  const absl::Status flushed = FlushAll();
  uint64_t bytes = 0;
  int64_t epoch = 0;
  {
    absl::MutexLock lock(&mutex_);
    is_aside_ = true;
    // What could not be written waits until the mission is wanted again.
    if (!flushed.ok()) return flushed;
    bytes_aside_ = bytes = contents_.live_bytes() + pictures_.bytes();
    epoch = epoch_;
    is_loaded_ = false;
    contents_ = MissionContents();
    pictures_ = PictureBook();
  }
  return Name(
      pool_
          .WriteAgain(
              {{"UPDATE corbslam.missions SET state = 3, summary = $3,"
                " summary_checksum = $4, bytes = $5, lease_until = NULL WHERE mission_id = $1 AND "
                "epoch = $2",
                {Id(), SqlValue::Number(epoch), SqlValue::Bytes(std::string(summary)),
                 SqlValue::Bits(SummaryChecksum(std::string(summary))), SqlValue::Bits(bytes)}}})
          .status());
}

absl::StatusOr<std::string> PostgresMission::ReadSummary() const {
  {
    absl::MutexLock lock(&mutex_);
    if (!is_aside_) return Name(absl::NotFoundError("it does not lie aside"));
  }
  const auto read =
      pool_.Read({{"SELECT summary, summary_checksum FROM corbslam.missions"
                   " WHERE mission_id = $1 AND state = 3 AND summary IS NOT NULL",
                   {Id()}}});
  RETURN_IF_ERROR(Name(read.status()));
  if (read->front().rows() == 0) return Name(absl::NotFoundError("no summary is kept of it"));
  std::string summary = read->front().Text(0, 0);
  if (SummaryChecksum(summary) != read->front().Bits(0, 1)) {
    return Name(absl::DataLossError("its summary does not fit its checksum"));
  }
  return summary;
}

absl::Status PostgresMission::Delete() {
  int64_t epoch = 0;
  {
    absl::MutexLock lock(&mutex_);
    if (absl::IsFailedPrecondition(failure_)) return failure_;
    is_deleted_ = true;
    while (is_flushing_) flushed_.Wait(&mutex_);
    if (!is_made_ && !unknown_.has_value()) return absl::OkStatus();
    epoch = is_loaded_ ? epoch_ : 0;
  }
  const absl::Status deleted = Name(DeleteRow(epoch));
  if (!deleted.ok()) {
    absl::MutexLock lock(&mutex_);
    is_deleted_ = false;
  }
  return deleted;
}

absl::Status PostgresMission::DeleteRow(int64_t epoch) {
  // Of missions that are shared, one that this process has not read may be another one's.
  const int64_t own = holder_.lease > absl::ZeroDuration() ? holder_.id : 0;
  // A row whose making is in the air would come to be after its deletion: the insertion waits for
  // it.
  ASSIGN_OR_RETURN(const std::vector<SqlResult> results,
                   pool_.WriteAgain({InsertMissionRow(id_, &name_, MissionStage::kInUse, holder_),
                                     {"UPDATE corbslam.missions SET name = NULL, state = 2"
                                      " WHERE mission_id = $1 AND (epoch = $2 OR ($2 = 0 AND"
                                      " ($3 = 0 OR holder = $3 OR state IN (1, 3))))",
                                      {Id(), SqlValue::Number(epoch), SqlValue::Number(own)}},
                                     SelectMissionRow(id_)}));
  const absl::StatusOr<MissionRow> row = MissionRowOf(results.back());
  if (!row.ok() || row->stage == MissionStage::kDeleted) return absl::OkStatus();
  return absl::FailedPreconditionError("another process has it, and only that one may delete it");
}

SqlStatement PostgresMission::DropUnusedPayloads() const {
  return {
      "DELETE FROM corbslam.payloads WHERE mission_id = $1 AND NOT EXISTS"
      " (SELECT 1 FROM corbslam.keyframes WHERE keyframes.mission_id = payloads.mission_id"
      " AND keyframes.hash = payloads.hash)",
      {Id()}};
}

void PostgresMission::TidyUp() {
  // Keyframes that came again with other features have left theirs.
  const absl::Status tidied =
      pool_
          .WriteAgain({{"SELECT mission_id FROM corbslam.missions WHERE mission_id = $1 FOR UPDATE",
                        {Id()}},
                       DropUnusedPayloads()})
          .status();
  LOG_IF(WARNING, !tidied.ok()) << "a mission lies aside as it is: " << Name(tidied);
}

bool PostgresMission::IsHeld() const {
  absl::MutexLock lock(&mutex_);
  return is_loaded_ && is_made_ && !is_aside_ && !is_deleted_ &&
         !absl::IsFailedPrecondition(failure_);
}

absl::Status PostgresMission::CheckStillHeld() {
  const auto read = pool_.Read({SelectMissionRow(id_)});
  // Who can't be asked has not said that it is lost.
  if (!read.ok()) return absl::UnavailableError(read.status().message());
  const absl::StatusOr<MissionRow> row = MissionRowOf(read->front());
  absl::MutexLock lock(&mutex_);
  if (!is_loaded_ || is_aside_ || is_deleted_) return absl::OkStatus();
  const absl::Status turn =
      row.ok() ? CheckTurn(*row) : absl::FailedPreconditionError("another process has deleted it");
  if (!turn.ok()) failure_ = Name(turn);
  return turn.ok() ? turn : failure_;
}

absl::Status PostgresMission::Failure() const {
  absl::MutexLock lock(&mutex_);
  return failure_;
}

absl::Status PostgresMission::Release(const std::string& wanted) {
  int64_t epoch = 0;
  {
    absl::MutexLock lock(&mutex_);
    if (!is_made_) return absl::OkStatus();
    epoch = epoch_;
  }
  return pool_
      .WriteAgain(
          {{"UPDATE corbslam.missions SET lease_until = NULL, holder = 0,"
            " wanted_store = CASE WHEN $4 <> '' THEN $4 ELSE wanted_store END,"
            " moved_at = CASE WHEN $4 <> '' THEN clock_timestamp() ELSE moved_at END"
            " WHERE mission_id = $1 AND holder = $2 AND epoch = $3",
            {Id(), SqlValue::Number(holder_.id), SqlValue::Number(epoch), SqlValue::Text(wanted)}}})
      .status();
}

absl::Status PostgresMission::CheckWritable() {
  {
    absl::MutexLock lock(&mutex_);
    // What another process has, or what is damaged, is that mission's trouble.
    if (failure_.ok() || absl::IsFailedPrecondition(failure_) || !CheckOpen().ok()) {
      return absl::OkStatus();
    }
  }
  return FlushAll();
}

}  // namespace corbslam::map_store

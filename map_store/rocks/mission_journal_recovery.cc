// Implements the part of MissionJournal that reads what is in its folder.
#include <algorithm>
#include <limits>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/formats.h"
#include "map_store/archive/record_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/rocks/durable_mark.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/mission_journal.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status WithPlace(const absl::Status& status, const std::string& place) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(place, ": ", status.message()));
}

}  // namespace

absl::Status MissionJournal::ToReadStatus(const rocksdb::Status& status) const {
  if (status.ok() || status.IsAborted()) return ToStatus(status);
  // What can't be read is lost, whatever the reason: a sector, a file that has gone.
  return Note(absl::DataLossError(
      absl::StrCat("journal ", database_->directory(), ": ", status.ToString())));
}

absl::Status MissionJournal::Load() {
  RETURN_IF_ERROR(LoadRecordsOnly());
  const std::string place = absl::StrCat("journal ", database_->directory());
  RETURN_IF_ERROR(Note(WithPlace(LoadFeatures(), place)));
  return Note(WithPlace(LoadPictures(), place));
}

absl::Status MissionJournal::LoadRecordsOnly() {
  const std::string place = absl::StrCat("journal ", database_->directory());
  std::string bytes;
  rocksdb::Status found = database_->Get(map_store::FormatKey(), &bytes);
  if (found.ok()) RETURN_IF_ERROR(TakeFormat(bytes, place));
  // The number was durable before the folder was a mission's.
  if (found.IsNotFound()) return Note(absl::DataLossError(place + ": its format is lost"));
  RETURN_IF_ERROR(ToReadStatus(found));
  found = database_->Get(MissionKey(name_), &bytes);
  if (found.IsNotFound()) {
    RETURN_IF_ERROR(Note(WithPlace(CheckMark(), place)));
    return absl::NotFoundError(place + ": nothing was acknowledged");
  }
  RETURN_IF_ERROR(ToReadStatus(found));
  const absl::StatusOr<MissionHeader> header = DecodeHeader(bytes);
  RETURN_IF_ERROR(Note(WithPlace(header.status(), place)));
  if (header->snapshot_position == kIncomplete) {
    return absl::NotFoundError(place + ": it was not whole yet");
  }
  {
    absl::MutexLock lock(&mutex_);
    is_marked_ = true;
    last_ = header->snapshot_position;
    contents_.NoteSnapshot(header->snapshot_position, header->snapshot_bytes, {});
  }
  RETURN_IF_ERROR(Note(WithPlace(LoadRecords(header->snapshot_position), place)));
  return Note(WithPlace(CheckMark(), place));
}

absl::Status MissionJournal::TakeFormat(const std::string& bytes, const std::string& place) {
  const absl::StatusOr<uint32_t> format = CheckFormat(bytes);
  RETURN_IF_ERROR(Note(WithPlace(format.status(), place)));
  if (*format == kJournalFormat || options_.only_read) return absl::OkStatus();
  return WriteFormat();
}

absl::Status MissionJournal::CheckMark() {
  absl::MutexLock marking(&marking_);
  absl::MutexLock lock(&mutex_);
  marked_ = ReadDurableMark(database_->directory());
  if (last_ >= marked_) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      "record ", marked_, " was durable, and only those up to ", last_,
      " are there: a log or a list of files (*.log, MANIFEST-*) is lost or ends early"));
}

absl::Status MissionJournal::LoadRecords(Position snapshot_position) {
  const std::string records = RecordKey(name_, snapshot_position + 1);
  const std::string end = EndOfPrefix(MissionPrefix(JournalPart::kRecord, name_));
  RETURN_IF_ERROR(database_->Scan(records, end, [&](std::string_view key, std::string_view value) {
    absl::MutexLock lock(&mutex_);
    last_ = std::max(last_, map_store::PositionOf(key));
    contents_.NoteRecord(map_store::PositionOf(key), value.size());
    return absl::OkStatus();
  }));
  absl::MutexLock lock(&mutex_);
  written_ = synced_ = last_;
  return absl::OkStatus();
}

absl::Status MissionJournal::LoadFeatures() {
  const std::string features = MissionPrefix(JournalPart::kFeatures, name_);
  return database_->Scan(features, EndOfPrefix(features),
                         [&](std::string_view key, std::string_view value) {
                           absl::MutexLock lock(&mutex_);
                           contents_.NoteFeatures(map_store::KeyframeOf(key), last_, value.size());
                           return absl::OkStatus();
                         });
}

absl::StatusOr<Features> MissionJournal::ReadFeatures(KeyframeId id) const {
  std::string bytes;
  const rocksdb::Status read = database_->Get(FeaturesKey(name_, id), &bytes);
  if (read.ok()) return map_store::DecodeFeatures(bytes);
  return absl::DataLossError(
      absl::StrCat("features of keyframe ", ToString(id), ": ", read.ToString()));
}

FeatureLoader MissionJournal::LoaderFor(const Journal::Replay& replay) const {
  if (!replay.with_features) return nullptr;
  return [this](KeyframeId id) { return ReadFeatures(id); };
}

absl::Status MissionJournal::ReplaySnapshot(Position position,
                                            const Journal::Replay& replay) const {
  std::string bytes;
  RETURN_IF_ERROR(database_->Scan(SnapshotKey(name_, position, 0),
                                  SnapshotKey(name_, position + 1, 0),
                                  [&](std::string_view, std::string_view chunk) {
                                    bytes.append(chunk);
                                    return absl::OkStatus();
                                  }));
  absl::StatusOr<MissionState> state = map_store::DecodeState(bytes, LoaderFor(replay));
  RETURN_IF_ERROR(WithPlace(state.status(), absl::StrCat("snapshot ", position)));
  return replay.on_snapshot(*std::move(state));
}

absl::Status MissionJournal::ReplayRecords(const Journal::Replay& replay,
                                           Position& position) const {
  const FeatureLoader load = LoaderFor(replay);
  const std::string end = replay.until == std::numeric_limits<Position>::max()
                              ? EndOfPrefix(MissionPrefix(JournalPart::kRecord, name_))
                              : RecordKey(name_, replay.until + 1);
  return database_->Scan(
      RecordKey(name_, position + 1), end,
      [&](std::string_view key, std::string_view bytes) -> absl::Status {
        position = map_store::PositionOf(key);
        const absl::StatusOr<JournalRecord> record = map_store::DecodeRecord(bytes, load);
        const absl::Status status = record.ok() ? replay.on_record(*record) : record.status();
        RETURN_IF_ERROR(WithPlace(status, absl::StrCat("record ", position)));
        const auto* update = std::get_if<BatchRecord>(&*record);
        if (update == nullptr) return absl::OkStatus();
        absl::MutexLock lock(&mutex_);
        for (const KeyframeRemoval& removal : update->batch->removed_keyframes) {
          contents_.NoteRemoved(removal.id, position);
        }
        return absl::OkStatus();
      });
}

absl::StatusOr<Journal::Position> MissionJournal::Recover(const Journal::Replay& replay) const {
  RETURN_IF_ERROR(Damage());
  std::string encoded;
  RETURN_IF_ERROR(ToReadStatus(database_->Get(MissionKey(name_), &encoded)));
  const absl::StatusOr<MissionHeader> header = DecodeHeader(encoded);
  absl::Status status = header.status();
  Position position = header.ok() ? header->snapshot_position : 0;
  if (position > 0) status = ReplaySnapshot(position, replay);
  if (status.ok()) status = ReplayRecords(replay, position);
  if (status.ok()) return position;
  return Note(
      WithPlace(status, absl::StrCat("journal ", database_->directory(), ", mission ", name_)));
}

absl::Status MissionJournal::Verify() const {
  RETURN_IF_ERROR(Damage());
  return ToStatus(database_->VerifyChecksums());
}

}  // namespace corbslam::map_store

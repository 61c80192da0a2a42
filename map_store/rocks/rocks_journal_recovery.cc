// Implements the part of RocksJournal that reads what is in its folder.
#include <algorithm>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/archive/archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/rocks_database.h"
#include "map_store/rocks/rocks_journal.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::Status RocksJournal::LoadMissions() {
  std::string bytes;
  const rocksdb::Status found = database_->Get(map_store::FormatKey(), &bytes);
  if (found.IsNotFound()) return WriteFormat();
  RETURN_IF_ERROR(ToStatus(found));
  ArchiveReader reader(bytes);
  uint32_t format = 0;
  reader(format);
  if (!reader.done() || format == 0) {
    return absl::DataLossError(
        absl::StrCat("journal ", options_.directory, ": its format's number is damaged"));
  }
  if (format < kOldestJournalFormat || format > kJournalFormat) {
    return absl::FailedPreconditionError(
        absl::StrCat("journal ", options_.directory, " has format ", format,
                     ", this program reads ", kOldestJournalFormat, " to ", kJournalFormat));
  }
  ASSIGN_OR_RETURN(const std::vector<std::string> names, ListMissions());
  absl::MutexLock lock(&mutex_);
  for (const std::string& name : names) RETURN_IF_ERROR(LoadMission(name));
  // An older program would not understand what is written from now on.
  return format == kJournalFormat ? absl::OkStatus() : WriteFormat();
}

absl::Status RocksJournal::LoadMission(const std::string& name) {
  std::string encoded;
  RETURN_IF_ERROR(ToStatus(database_->Get(MissionKey(name), &encoded)));
  ASSIGN_OR_RETURN(const MissionHeader header, DecodeHeader(encoded));
  if (header.snapshot_position == kNotWhole) return Erase(name);
  MissionFiles& files = FilesOf(name);
  files.is_listed = true;
  files.snapshot_bytes = header.snapshot_bytes;
  Position last = header.snapshot_position;
  const std::string records = MissionPrefix(JournalPart::kRecord, name);
  RETURN_IF_ERROR(database_->Scan(records, EndOfPrefix(records),
                                  [&](std::string_view key, std::string_view value) {
                                    const Position position = map_store::PositionOf(key);
                                    last = std::max(last, position);
                                    NoteRecord(position, value.size(), files);
                                    return absl::OkStatus();
                                  }));
  const std::string features = MissionPrefix(JournalPart::kFeatures, name);
  RETURN_IF_ERROR(
      database_->Scan(features, EndOfPrefix(features), [&](std::string_view key, std::string_view) {
        files.features[map_store::KeyframeOf(key)] = last;
        return absl::OkStatus();
      }));
  last_ = std::max(last_, last);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> RocksJournal::ListMissions() const {
  std::vector<std::string> names;
  const std::string first(1, static_cast<char>(JournalPart::kMission));
  RETURN_IF_ERROR(
      database_->Scan(first, EndOfPrefix(first), [&](std::string_view key, std::string_view) {
        names.emplace_back(key.substr(1, key.size() - 2));
        return absl::OkStatus();
      }));
  return names;
}

absl::StatusOr<Features> RocksJournal::LoadFeatures(const std::string& mission,
                                                    KeyframeId id) const {
  std::string bytes;
  const rocksdb::Status read = database_->Get(FeaturesKey(mission, id), &bytes);
  if (read.ok()) return map_store::DecodeFeatures(bytes);
  return absl::DataLossError(
      absl::StrCat("features of keyframe ", ToString(id), ": ", read.ToString()));
}

absl::Status RocksJournal::ReplaySnapshot(const std::string& mission, Position position,
                                          const Replay& replay) const {
  std::string bytes;
  RETURN_IF_ERROR(database_->Scan(SnapshotKey(mission, position, 0),
                                  SnapshotKey(mission, position + 1, 0),
                                  [&](std::string_view, std::string_view chunk) {
                                    bytes.append(chunk);
                                    return absl::OkStatus();
                                  }));
  ASSIGN_OR_RETURN(MissionState state, map_store::DecodeState(bytes, LoaderFor(mission, replay)));
  return replay.on_snapshot(std::move(state));
}

absl::Status RocksJournal::ReplayRecords(const std::string& mission, const Replay& replay,
                                         Position& position) const {
  const FeatureLoader load = LoaderFor(mission, replay);
  const std::string prefix = MissionPrefix(JournalPart::kRecord, mission);
  const std::string end = replay.until == std::numeric_limits<Position>::max()
                              ? EndOfPrefix(prefix)
                              : RecordKey(mission, replay.until + 1);
  return database_->Scan(
      RecordKey(mission, position + 1), end,
      [&](std::string_view key, std::string_view bytes) -> absl::Status {
        position = map_store::PositionOf(key);
        const absl::StatusOr<JournalRecord> record = map_store::DecodeRecord(bytes, load);
        absl::Status status = record.ok() ? replay.on_record(*record) : record.status();
        if (status.ok()) return status;
        return absl::Status(status.code(),
                            absl::StrCat("record ", position, ": ", status.message()));
      });
}

FeatureLoader RocksJournal::LoaderFor(const std::string& mission, const Replay& replay) const {
  if (!replay.with_features) return nullptr;
  return [this, mission](KeyframeId id) { return LoadFeatures(mission, id); };
}

absl::StatusOr<Journal::Position> RocksJournal::Recover(absl::string_view mission,
                                                        const Replay& replay) const {
  const std::string name(mission);
  std::string encoded;
  const rocksdb::Status found = database_->Get(MissionKey(name), &encoded);
  if (found.IsNotFound()) return 0;
  RETURN_IF_ERROR(ToStatus(found));
  const absl::StatusOr<MissionHeader> header = DecodeHeader(encoded);
  absl::Status status = header.status();
  Position position = header.ok() ? header->snapshot_position : 0;
  if (position > 0) status = ReplaySnapshot(name, position, replay);
  if (status.ok()) status = ReplayRecords(name, replay, position);
  if (status.ok()) return position;
  return absl::Status(status.code(), absl::StrCat("journal ", options_.directory, ", mission ",
                                                  name, ": ", status.message()));
}

}  // namespace corbslam::map_store

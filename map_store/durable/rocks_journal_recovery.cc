// RocksJournal and what it finds in its folder.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/durable/archive.h"
#include "map_store/durable/journal_keys.h"
#include "map_store/durable/mission_header.h"
#include "map_store/durable/rocks_database.h"
#include "map_store/durable/rocks_journal.h"
#include "map_store/durable/state_archive.h"
#include "slam/util/status_macros.h"

namespace corbslam {

using map_store::ArchiveReader;
using map_store::DecodeHeader;
using map_store::EndOfPrefix;
using map_store::FeaturesKey;
using map_store::JournalPart;
using map_store::JournalRecord;
using map_store::kNotWhole;
using map_store::MissionHeader;
using map_store::MissionKey;
using map_store::MissionPrefix;
using map_store::RecordKey;
using map_store::SnapshotKey;

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
  if (format != map_store::kJournalFormat) {
    return absl::FailedPreconditionError(
        absl::StrCat("journal ", options_.directory, " has format ", format,
                     ", this program reads ", map_store::kJournalFormat));
  }
  ASSIGN_OR_RETURN(const std::vector<std::string> names, ListMissions());
  absl::MutexLock lock(&mutex_);
  for (const std::string& name : names) RETURN_IF_ERROR(LoadMission(name));
  synced_ = last_;
  return absl::OkStatus();
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
                                    last = std::max<Position>(last, map_store::PositionOf(key));
                                    files.bytes_since_snapshot += value.size();
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

absl::Status RocksJournal::Recover(absl::string_view mission, const Replay& replay) const {
  const std::string name(mission);
  const auto locate = [&](const absl::Status& status) {
    return absl::Status(status.code(), absl::StrCat("journal ", options_.directory, ", mission ",
                                                    name, ": ", status.message()));
  };
  std::string encoded;
  const rocksdb::Status found = database_->Get(MissionKey(name), &encoded);
  if (found.IsNotFound()) return absl::OkStatus();
  RETURN_IF_ERROR(ToStatus(found));
  const absl::StatusOr<MissionHeader> header = DecodeHeader(encoded);
  if (!header.ok()) return locate(header.status());
  const map_store::FeatureLoader load = [&](KeyframeId id) -> absl::StatusOr<Features> {
    std::string bytes;
    const rocksdb::Status read = database_->Get(FeaturesKey(name, id), &bytes);
    if (!read.ok()) {
      return absl::DataLossError(
          absl::StrCat("features of keyframe ", ToString(id), ": ", read.ToString()));
    }
    return map_store::DecodeFeatures(bytes);
  };
  if (header->snapshot_position > 0) {
    std::string bytes;
    const std::string first = SnapshotKey(name, header->snapshot_position, 0);
    const std::string end = SnapshotKey(name, header->snapshot_position + 1, 0);
    const absl::Status read =
        database_->Scan(first, end, [&](std::string_view, std::string_view chunk) {
          bytes.append(chunk);
          return absl::OkStatus();
        });
    if (!read.ok()) return locate(read);
    absl::StatusOr<map_store::MissionState> state = map_store::DecodeState(bytes, load);
    if (!state.ok()) return locate(state.status());
    RETURN_IF_ERROR(replay.on_snapshot(*std::move(state)));
  }
  const std::string end = EndOfPrefix(MissionPrefix(JournalPart::kRecord, name));
  const absl::Status replayed = database_->Scan(
      RecordKey(name, header->snapshot_position + 1), end,
      [&](std::string_view key, std::string_view bytes) -> absl::Status {
        const absl::StatusOr<JournalRecord> record = map_store::DecodeRecord(bytes, load);
        absl::Status status = record.ok() ? replay.on_record(*record) : record.status();
        if (status.ok()) return status;
        return absl::Status(status.code(), absl::StrCat("record ", map_store::PositionOf(key), ": ",
                                                        status.message()));
      });
  return replayed.ok() ? replayed : locate(replayed);
}

}  // namespace corbslam

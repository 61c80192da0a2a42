#include "map_store/rocks/salvaged_journal.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/record_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/rocks/durable_mark.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

using KeypointCounts = std::map<KeyframeId, size_t>;

KeypointCounts CountKeypoints(const MissionState& state) {
  KeypointCounts counts;
  for (const auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      counts[keyframe_id] = keyframe.points.size();
    }
  }
  return counts;
}

KeypointCounts CountKeypoints(const JournalRecord& record) {
  KeypointCounts counts;
  if (const auto* update = std::get_if<BatchRecord>(&record)) {
    for (const FullKeyframe& keyframe : update->batch->full_keyframes) {
      counts[keyframe.payload->id] = keyframe.payload->features.keypoints.size();
    }
  }
  return counts;
}

absl::Status CheckRoomForCopy(const std::string& path, const std::string& scratch) {
  const uint64_t bytes = BytesIn(path);
  std::error_code error;
  const auto space =
      std::filesystem::space(std::filesystem::absolute(scratch).parent_path(), error);
  if (error || space.available > bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat("a copy of ", path, " takes ", bytes,
                                                   " bytes, and the disk of ", scratch, " has ",
                                                   space.available, " free"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<SalvagedJournal>> SalvagedJournal::Open(const std::string& mission,
                                                                       const std::string& path,
                                                                       const std::string& scratch,
                                                                       Way way) {
  std::unique_ptr<SalvagedJournal> journal(new SalvagedJournal(mission, scratch));
  journal->report_.not_opened = absl::DataLossError("some of its files are lost");
  RETURN_IF_ERROR(way == Way::kAsItIs ? journal->OpenDatabase(path) : journal->OpenCopy(path));
  journal->report_.durable = ReadDurableMark(path);
  return journal;
}

SalvagedJournal::SalvagedJournal(const std::string& mission, std::string scratch)
    : ReadOnlyJournal(mission), scratch_(std::move(scratch)) {}

SalvagedJournal::~SalvagedJournal() {
  database_.reset();
  if (!has_scratch_) return;
  std::error_code error;
  std::filesystem::remove_all(scratch_, error);
}

absl::Status SalvagedJournal::OpenDatabase(const std::string& path) {
  database_ = std::make_unique<RocksDatabase>(path, nullptr, MakeBlockCache());
  const rocksdb::Status opened = database_->Open(RocksDatabase::Mode::kSalvage);
  std::string format;
  if (opened.ok() && database_->Get(map_store::FormatKey(), &format).ok()) {
    const absl::StatusOr<uint32_t> known = CheckFormat(format);
    if (absl::IsFailedPrecondition(known.status())) return known.status();
  }
  report_.not_opened = opened.ok() ? absl::OkStatus() : absl::DataLossError(opened.ToString());
  if (opened.ok()) return absl::OkStatus();
  return OpenCopy(path);
}

absl::Status SalvagedJournal::OpenCopy(const std::string& path) {
  database_.reset();
  RETURN_IF_ERROR(CheckRoomForCopy(path, scratch_));
  std::error_code error;
  if (std::filesystem::exists(scratch_, error)) {
    return absl::AlreadyExistsError(
        absl::StrCat("a copy is to be made in ", scratch_, ", which is there already: remove it"));
  }
  has_scratch_ = true;
  std::filesystem::copy(path, scratch_, std::filesystem::copy_options::recursive, error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("can't copy ", path, " to ", scratch_, ": ", error.message()));
  }
  database_ = std::make_unique<RocksDatabase>(scratch_, nullptr, MakeBlockCache());
  const rocksdb::Status opened = database_->Open(RocksDatabase::Mode::kBestEfforts);
  if (opened.ok()) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat(path, ": nothing can be had: ", report_.not_opened.message(),
                   "; without its list of ", "files and log: ", opened.ToString()));
}

absl::StatusOr<Journal::Position> SalvagedJournal::FindSnapshot() const {
  std::string bytes;
  if (database_->Get(MissionKey(mission()), &bytes).ok()) {
    const absl::StatusOr<MissionHeader> header = DecodeHeader(bytes);
    if (header.ok() && header->snapshot_position == kIncomplete) {
      return absl::NotFoundError(
          absl::StrCat("mission ", mission(), " was never whole: its making was cut short"));
    }
    if (header.ok()) return header->snapshot_position;
  }
  Position newest = 0;
  const std::string first = MissionPrefix(JournalPart::kSnapshot, mission());
  // The position stands before the chunk's number, 4 bytes.
  const absl::Status scanned =
      database_->Scan(first, EndOfPrefix(first), [&](std::string_view key, std::string_view) {
        newest = std::max(newest, map_store::PositionOf(key.substr(0, key.size() - 4)));
        return absl::OkStatus();
      });
  if (!scanned.ok()) report_.ended = scanned;
  return newest;
}

absl::StatusOr<Features> SalvagedJournal::FeaturesOrStandIn(KeyframeId id, size_t count) const {
  std::string bytes;
  const rocksdb::Status read = database_->Get(FeaturesKey(mission(), id), &bytes);
  absl::StatusOr<Features> features =
      read.ok() ? map_store::DecodeFeatures(bytes) : absl::DataLossError(read.ToString());
  if (features.ok() && features->keypoints.size() == count) return features;
  report_.without_features[id] = features.ok() ? "they are others than the keyframe's"
                                               : std::string(features.status().message());
  Features stand_in;
  stand_in.keypoints.resize(count);
  stand_in.descriptors.resize(count);
  return stand_in;
}

absl::Status SalvagedJournal::ReplaySnapshot(Position position, const Replay& replay) const {
  std::string bytes;
  RETURN_IF_ERROR(database_->Scan(SnapshotKey(mission(), position, 0),
                                  SnapshotKey(mission(), position + 1, 0),
                                  [&](std::string_view, std::string_view chunk) {
                                    bytes.append(chunk);
                                    return absl::OkStatus();
                                  }));
  ASSIGN_OR_RETURN(const MissionState bare, map_store::DecodeState(bytes, nullptr));
  const KeypointCounts counts = CountKeypoints(bare);
  ASSIGN_OR_RETURN(MissionState state, map_store::DecodeState(bytes, [&](KeyframeId id) {
                     return FeaturesOrStandIn(id, counts.at(id));
                   }));
  return replay.on_snapshot(std::move(state));
}

absl::Status SalvagedJournal::ReplayRecord(std::string_view bytes, const Replay& replay) const {
  ASSIGN_OR_RETURN(const JournalRecord bare, map_store::DecodeRecord(bytes, nullptr));
  const KeypointCounts counts = CountKeypoints(bare);
  ASSIGN_OR_RETURN(const JournalRecord record, map_store::DecodeRecord(bytes, [&](KeyframeId id) {
                     return FeaturesOrStandIn(id, counts.at(id));
                   }));
  return replay.on_record(record);
}

absl::Status SalvagedJournal::ReplayRecords(Position after, const Replay& replay) const {
  return database_->Scan(
      RecordKey(mission(), after + 1), EndOfPrefix(MissionPrefix(JournalPart::kRecord, mission())),
      [&](std::string_view key, std::string_view bytes) -> absl::Status {
        const Position position = map_store::PositionOf(key);
        const absl::Status status = ReplayRecord(bytes, replay);
        if (!status.ok()) {
          return absl::Status(status.code(),
                              absl::StrCat("record ", position, ": ", status.message()));
        }
        ++report_.records;
        report_.last = position;
        return absl::OkStatus();
      });
}

absl::StatusOr<Journal::Position> SalvagedJournal::Recover(absl::string_view,
                                                           const Replay& replay) const {
  ASSIGN_OR_RETURN(const Position snapshot, FindSnapshot());
  absl::Status ended = snapshot > 0 ? ReplaySnapshot(snapshot, replay) : absl::OkStatus();
  if (!ended.ok()) {
    ended = absl::DataLossError(absl::StrCat("snapshot ", snapshot, ": ", ended.message()));
  } else {
    report_.snapshot = report_.last = snapshot;
    ended = ReplayRecords(snapshot, replay);
  }
  if (!ended.ok()) report_.ended = ended;
  return report_.last;
}

}  // namespace corbslam::map_store

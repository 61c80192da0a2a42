#include "map_store/rocks/rocks_journal.h"

#include <rocksdb/write_batch.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <variant>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "map_store/archive/archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/lock_holder.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

namespace {

constexpr size_t kChunkBytes = 1 << 20;

std::shared_ptr<const BatchBytes> EncodeBatch(const BatchRecord& record) {
  auto bytes = std::make_shared<BatchBytes>();
  bytes->record = map_store::EncodeRecord(record);
  for (const FullKeyframe& keyframe : record.batch->full_keyframes) {
    bytes->features.emplace_back(keyframe.payload->id,
                                 map_store::EncodeFeatures(*keyframe.payload));
  }
  return bytes;
}

// Returns what is to be written of the record; only batches have features.
std::shared_ptr<const BatchBytes> BytesOf(const JournalRecord& record) {
  if (const auto* batch = std::get_if<BatchRecord>(&record)) {
    return batch->bytes != nullptr ? batch->bytes : EncodeBatch(*batch);
  }
  return std::make_shared<const BatchBytes>(BatchBytes{map_store::EncodeRecord(record), {}});
}

// RocksDB locks this file of the folder as long as it has the database open.
constexpr char kLockName[] = "LOCK";

// Says why a database can't be opened, with the process that has it open, where there is one.
std::string ExplainOpenFailure(const std::string& directory, const rocksdb::Status& status) {
  const std::string said = status.ToString();
  const bool is_locked = absl::StrContains(said, "While lock file") ||
                         absl::StrContains(said, "lock hold by current process");
  if (!is_locked) return said;
  const std::string lock = absl::StrCat(directory, "/", kLockName);
  return absl::StrCat("the folder is in use: ", DescribeLockHolder(lock),
                      "; stop it, or choose another folder");
}

}  // namespace

RocksJournal::RocksJournal(const RocksJournalOptions& options,
                           std::unique_ptr<RocksDatabase> database)
    : options_(options), database_(std::move(database)) {}

RocksJournal::~RocksJournal() = default;

absl::Status RocksJournal::ToStatus(const rocksdb::Status& status) const {
  if (status.ok()) return absl::OkStatus();
  const std::string message = absl::StrCat("journal ", options_.directory, ": ", status.ToString());
  if (status.IsNoSpace()) return absl::ResourceExhaustedError(message);
  if (status.IsCorruption()) return absl::DataLossError(message);
  return absl::UnavailableError(message);
}

absl::StatusOr<std::unique_ptr<RocksJournal>> RocksJournal::Open(
    const RocksJournalOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.directory, error);
  if (error) {
    return absl::FailedPreconditionError(
        absl::StrCat("journal ", options.directory, ": ", error.message()));
  }
  auto database = std::make_unique<RocksDatabase>(options.directory, options.env);
  const rocksdb::Status status = database->Open();
  if (!status.ok()) {
    const std::string message = absl::StrCat("journal ", options.directory, ": ",
                                             ExplainOpenFailure(options.directory, status));
    if (status.IsCorruption()) return absl::DataLossError(message);
    return absl::FailedPreconditionError(message);
  }
  std::unique_ptr<RocksJournal> journal(new RocksJournal(options, std::move(database)));
  RETURN_IF_ERROR(journal->LoadMissions());
  return journal;
}

absl::Status RocksJournal::WriteFormat() {
  ArchiveWriter writer;
  writer(kJournalFormat);
  rocksdb::WriteBatch batch;
  batch.Put(map_store::FormatKey(), writer.Take());
  return ToStatus(database_->Write(batch, true));
}

absl::Status RocksJournal::CheckRoom(uint64_t bytes) const {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(options_.directory, error);
  // Where the system doesn't tell how much room there is, the write will.
  if (error || space.available >= options_.min_free_bytes + bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("journal ", options_.directory, ": the disk has ", space.available,
                   " bytes free; ", options_.min_free_bytes, " are kept, ", bytes, " to write"));
}

absl::Status RocksJournal::CheckRoomForRecord(uint64_t bytes) {
  const absl::Status room = CheckRoom(bytes);
  record_without_room_ = room.ok() ? 0 : bytes;
  return room;
}

absl::Status RocksJournal::CheckWritable() {
  RETURN_IF_ERROR(CheckRoom(record_without_room_));
  // The write repeats what is there already, to find out whether writing works.
  return database_->failed() ? WriteFormat() : absl::OkStatus();
}

RocksJournal::MissionFiles& RocksJournal::FilesOf(absl::string_view mission) {
  const auto it = missions_.find(std::string(mission));
  return it == missions_.end() ? missions_[std::string(mission)] : it->second;
}

void RocksJournal::NoteRecord(Position position, uint64_t bytes, MissionFiles& files) {
  files.records[position] = bytes;
  files.bytes_since_snapshot += bytes;
}

void RocksJournal::ForgetRecords(Position until, MissionFiles& files) {
  const auto end = files.records.upper_bound(until);
  for (auto it = files.records.begin(); it != end; ++it) files.bytes_since_snapshot -= it->second;
  files.records.erase(files.records.begin(), end);
}

Journal::Position RocksJournal::NextPosition() {
  absl::MutexLock lock(&mutex_);
  return ++last_;
}

void RocksJournal::Prepare(BatchRecord& record) const { record.bytes = EncodeBatch(record); }

void RocksJournal::Prepare(AdjustRecord& record) const {
  record.plan_bytes = std::make_shared<const PlanBytes>(EncodePlan(record.plan));
}

absl::StatusOr<Journal::Position> RocksJournal::Append(absl::string_view mission,
                                                       const JournalRecord& record) {
  const std::shared_ptr<const BatchBytes> bytes = BytesOf(record);
  const std::string name(mission);
  rocksdb::WriteBatch batch;
  for (const auto& [id, features] : bytes->features) batch.Put(FeaturesKey(name, id), features);
  RETURN_IF_ERROR(CheckRoomForRecord(batch.GetDataSize() + bytes->record.size()));
  const Position position = NextPosition();
  batch.Put(RecordKey(name, position), bytes->record);
  bool is_listed = false;
  {
    absl::MutexLock lock(&mutex_);
    is_listed = FilesOf(mission).is_listed;
  }
  if (!is_listed) batch.Put(MissionKey(name), Encode(MissionHeader()));
  RETURN_IF_ERROR(ToStatus(database_->Write(batch, false)));
  absl::MutexLock lock(&mutex_);
  if (options_.sync) unsynced_.insert(position);
  MissionFiles& files = FilesOf(mission);
  files.is_listed = true;
  NoteRecord(position, bytes->record.size(), files);
  for (const auto& [id, features] : bytes->features) files.features[id] = position;
  return position;
}

absl::Status RocksJournal::Sync(Position position) {
  if (!options_.sync) return absl::OkStatus();
  absl::MutexLock lock(&mutex_);
  // Records of one mission are written one after the other: once this one is safe, so are those
  // before it.
  while (unsynced_.contains(position) || being_synced_.contains(position)) {
    // One thread syncs for all that were written by then; the others wait for it.
    if (syncing_) {
      synced_changed_.Wait(&mutex_);
      continue;
    }
    syncing_ = true;
    being_synced_.swap(unsynced_);
    mutex_.Unlock();
    const absl::Status status = ToStatus(database_->SyncLog());
    mutex_.Lock();
    syncing_ = false;
    synced_changed_.SignalAll();
    if (!status.ok()) unsynced_.merge(being_synced_);
    being_synced_.clear();
    RETURN_IF_ERROR(status);
  }
  return absl::OkStatus();
}

bool RocksJournal::WantsSnapshot(absl::string_view mission) const {
  absl::MutexLock lock(&mutex_);
  const auto it = missions_.find(std::string(mission));
  return it != missions_.end() &&
         it->second.bytes_since_snapshot >
             std::max(options_.min_bytes_between_snapshots, it->second.snapshot_bytes);
}

std::vector<KeyframeId> RocksJournal::FindUnneeded(absl::string_view mission,
                                                   const JournalSnapshot& snapshot) {
  std::vector<KeyframeId> unneeded;
  absl::MutexLock lock(&mutex_);
  for (const auto& [id, position] : FilesOf(mission).features) {
    if (position > snapshot.position) continue;
    if (!std::binary_search(snapshot.keyframes.begin(), snapshot.keyframes.end(), id)) {
      unneeded.push_back(id);
    }
  }
  return unneeded;
}

absl::Status RocksJournal::WriteSnapshot(absl::string_view mission,
                                         const JournalSnapshot& snapshot) {
  const std::string name(mission);
  RETURN_IF_ERROR(CheckRoom(snapshot.state.size()));
  uint32_t chunks = 0;
  for (size_t begin = 0; begin < snapshot.state.size(); begin += kChunkBytes) {
    rocksdb::WriteBatch chunk;
    chunk.Put(SnapshotKey(name, snapshot.position, chunks++),
              snapshot.state.substr(begin, kChunkBytes));
    RETURN_IF_ERROR(ToStatus(database_->Write(chunk, false)));
    // Else the next record's sync would wait for the whole snapshot.
    if (options_.sync) RETURN_IF_ERROR(ToStatus(database_->SyncLog()));
  }
  const std::vector<KeyframeId> unneeded = FindUnneeded(mission, snapshot);
  const uint64_t size = snapshot.state.size();
  rocksdb::WriteBatch turn;
  turn.Put(MissionKey(name), Encode(MissionHeader{snapshot.position, size}));
  const std::string records = MissionPrefix(JournalPart::kRecord, name);
  turn.DeleteRange(records, RecordKey(name, snapshot.position + 1));
  const std::string snapshots = MissionPrefix(JournalPart::kSnapshot, name);
  turn.DeleteRange(snapshots, SnapshotKey(name, snapshot.position, 0));
  // This removes what an attempt that failed at the same position may have left behind.
  turn.DeleteRange(SnapshotKey(name, snapshot.position, chunks),
                   SnapshotKey(name, snapshot.position + 1, 0));
  for (const KeyframeId& id : unneeded) turn.Delete(FeaturesKey(name, id));
  RETURN_IF_ERROR(ToStatus(database_->Write(turn, true)));
  absl::MutexLock lock(&mutex_);
  MissionFiles& files = FilesOf(mission);
  files.snapshot_bytes = size;
  ForgetRecords(snapshot.position, files);
  for (const KeyframeId& id : unneeded) files.features.erase(id);
  return absl::OkStatus();
}

absl::Status RocksJournal::CreateMission(absl::string_view mission, const MissionState& state) {
  const std::string name(mission);
  rocksdb::WriteBatch mark;
  mark.Put(MissionKey(name), Encode(MissionHeader{kNotWhole, 0}));
  RETURN_IF_ERROR(ToStatus(database_->Write(mark, false)));
  const Position position = NextPosition();
  absl::Status status = WriteFeatures(name, state, position);
  if (status.ok()) {
    JournalSnapshot snapshot = map_store::TakeSnapshot(state);
    snapshot.position = position;
    status = WriteSnapshot(mission, snapshot);
  }
  if (!status.ok()) {
    // Should this fail as well, the next start does it.
    DeleteMission(mission).IgnoreError();
    return status;
  }
  absl::MutexLock lock(&mutex_);
  FilesOf(mission).is_listed = true;
  return absl::OkStatus();
}

absl::Status RocksJournal::WriteFeatures(const std::string& mission, const MissionState& state,
                                         Position position) {
  for (const auto& [id, local_map] : state.local_maps) {
    RETURN_IF_ERROR(CheckRoom(local_map.stored_bytes));
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      rocksdb::WriteBatch batch;
      batch.Put(FeaturesKey(mission, keyframe_id), map_store::EncodeFeatures(*keyframe.payload));
      RETURN_IF_ERROR(ToStatus(database_->Write(batch, false)));
      absl::MutexLock lock(&mutex_);
      FilesOf(mission).features[keyframe_id] = position;
    }
  }
  return absl::OkStatus();
}

absl::Status RocksJournal::Erase(const std::string& mission) {
  rocksdb::WriteBatch batch;
  batch.Delete(MissionKey(mission));
  for (const JournalPart part :
       {JournalPart::kRecord, JournalPart::kSnapshot, JournalPart::kFeatures}) {
    const std::string prefix = MissionPrefix(part, mission);
    batch.DeleteRange(prefix, EndOfPrefix(prefix));
  }
  return ToStatus(database_->Write(batch, true));
}

absl::Status RocksJournal::DeleteMission(absl::string_view mission) {
  const std::string name(mission);
  RETURN_IF_ERROR(Erase(name));
  absl::MutexLock lock(&mutex_);
  missions_.erase(name);
  return absl::OkStatus();
}

}  // namespace corbslam::map_store

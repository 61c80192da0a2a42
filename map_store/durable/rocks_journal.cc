#include "map_store/durable/rocks_journal.h"

#include <rocksdb/db.h>
#include <rocksdb/options.h>
#include <rocksdb/write_batch.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <system_error>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "map_store/durable/archive.h"
#include "map_store/durable/journal_keys.h"
#include "map_store/durable/state_archive.h"
#include "slam/util/status_macros.h"

namespace corbslam {

using map_store::ArchiveReader;
using map_store::ArchiveWriter;
using map_store::BatchRecord;
using map_store::EndOfPrefix;
using map_store::FeaturesKey;
using map_store::JournalPart;
using map_store::JournalRecord;
using map_store::MissionKey;
using map_store::MissionPrefix;
using map_store::RecordKey;
using map_store::SnapshotKey;

namespace {

constexpr uint32_t kFormat = 1;
constexpr size_t kChunkBytes = 1 << 20;

// What stands under a mission's key.
struct MissionHeader {
  uint64_t snapshot_position = 0;  // 0: there is none.
  uint64_t snapshot_bytes = 0;
};

std::string Encode(const MissionHeader& header) {
  ArchiveWriter writer;
  writer(header.snapshot_position, header.snapshot_bytes);
  return writer.Take();
}

absl::StatusOr<MissionHeader> DecodeHeader(std::string_view bytes) {
  ArchiveReader reader(bytes);
  MissionHeader header;
  reader(header.snapshot_position, header.snapshot_bytes);
  if (reader.done()) return header;
  return absl::DataLossError("a mission's header is damaged");
}

std::string_view View(const rocksdb::Slice& slice) { return {slice.data(), slice.size()}; }

rocksdb::Options MakeOptions(const RocksJournalOptions& options) {
  rocksdb::Options made;
  made.create_if_missing = true;
  // What a crash tore at the end of the log goes; damage anywhere else is refused.
  made.wal_recovery_mode = rocksdb::WALRecoveryMode::kTolerateCorruptedTailRecords;
  made.max_total_wal_size = 256 << 20;
  // Features are large and never change: compaction leaves them where they are.
  made.enable_blob_files = true;
  made.min_blob_size = 16 << 10;
  made.enable_blob_garbage_collection = true;
  made.keep_log_file_num = 5;
  made.info_log_level = rocksdb::InfoLogLevel::WARN_LEVEL;
  if (options.env != nullptr) made.env = options.env;
  return made;
}

}  // namespace

class RocksJournal::Database {
 public:
  explicit Database(std::unique_ptr<rocksdb::DB> db) : db_(std::move(db)) {}

  // After a write failed RocksDB takes no more until it has found that it can: by itself, every few
  // seconds, or told to try.
  rocksdb::Status Write(rocksdb::WriteBatch& batch, bool sync) {
    if (failed_.load()) db_->Resume().PermitUncheckedError();
    rocksdb::WriteOptions options;
    options.sync = sync;
    const rocksdb::Status status = db_->Write(options, &batch);
    failed_.store(!status.ok());
    return status;
  }
  rocksdb::Status SyncLog() {
    const rocksdb::Status status = db_->SyncWAL();
    if (!status.ok()) failed_.store(true);
    return status;
  }
  // The last write did not succeed.
  bool failed() const { return failed_.load(); }
  rocksdb::Status Get(const std::string& key, std::string* value) const {
    return db_->Get(rocksdb::ReadOptions(), key, value);
  }

  // Calls `visit(key, value)` for all keys from `first` on, up to `end`.
  template <typename Visit>
  absl::Status Scan(const std::string& first, const std::string& end, Visit visit) const {
    rocksdb::ReadOptions options;
    const rocksdb::Slice bound(end);
    options.iterate_upper_bound = &bound;
    const std::unique_ptr<rocksdb::Iterator> it(db_->NewIterator(options));
    for (it->Seek(first); it->Valid(); it->Next()) {
      RETURN_IF_ERROR(visit(View(it->key()), View(it->value())));
    }
    if (it->status().ok()) return absl::OkStatus();
    return absl::DataLossError(it->status().ToString());
  }

 private:
  const std::unique_ptr<rocksdb::DB> db_;
  std::atomic<bool> failed_ = false;
};

RocksJournal::RocksJournal(const RocksJournalOptions& options, std::unique_ptr<Database> database)
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
  rocksdb::DB* opened = nullptr;
  const rocksdb::Status status =
      rocksdb::DB::Open(MakeOptions(options), options.directory, &opened);
  if (!status.ok()) {
    const std::string message =
        absl::StrCat("journal ", options.directory, ": ", status.ToString());
    if (status.IsCorruption()) return absl::DataLossError(message);
    return absl::FailedPreconditionError(message);
  }
  auto database = std::make_unique<Database>(std::unique_ptr<rocksdb::DB>(opened));
  std::unique_ptr<RocksJournal> journal(new RocksJournal(options, std::move(database)));
  RETURN_IF_ERROR(journal->LoadMissions());
  return journal;
}

absl::Status RocksJournal::WriteFormat() {
  ArchiveWriter writer;
  writer(kFormat);
  rocksdb::WriteBatch batch;
  batch.Put(map_store::FormatKey(), writer.Take());
  return ToStatus(database_->Write(batch, true));
}

absl::Status RocksJournal::CheckRoom(uint64_t bytes) const {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(options_.directory, error);
  // Where the system doesn't tell, the write will.
  if (error || space.available >= options_.min_free_bytes + bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("journal ", options_.directory, ": the disk has ", space.available,
                   " bytes free; ", options_.min_free_bytes, " are kept, ", bytes, " to write"));
}

absl::Status RocksJournal::CheckWritable() {
  RETURN_IF_ERROR(CheckRoom(0));
  // Says what is there already.
  return database_->failed() ? WriteFormat() : absl::OkStatus();
}

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
  if (format > kFormat) {
    return absl::FailedPreconditionError(absl::StrCat("journal ", options_.directory,
                                                      " has format ", format,
                                                      ", this program reads up to ", kFormat));
  }
  ASSIGN_OR_RETURN(const std::vector<std::string> names, ListMissions());
  absl::MutexLock lock(&mutex_);
  for (const std::string& name : names) {
    MissionFiles& files = FilesOf(name);
    files.is_listed = true;
    std::string encoded;
    RETURN_IF_ERROR(ToStatus(database_->Get(MissionKey(name), &encoded)));
    ASSIGN_OR_RETURN(const MissionHeader header, DecodeHeader(encoded));
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
    RETURN_IF_ERROR(database_->Scan(features, EndOfPrefix(features),
                                    [&](std::string_view key, std::string_view) {
                                      files.features[map_store::KeyframeOf(key)] = last;
                                      return absl::OkStatus();
                                    }));
    last_ = std::max(last_, last);
  }
  synced_ = last_;
  return absl::OkStatus();
}

RocksJournal::MissionFiles& RocksJournal::FilesOf(absl::string_view mission) {
  const auto it = missions_.find(std::string(mission));
  return it == missions_.end() ? missions_[std::string(mission)] : it->second;
}

Journal::Position RocksJournal::BeginAppend() {
  absl::MutexLock lock(&mutex_);
  under_way_.insert(++last_);
  return last_;
}

void RocksJournal::EndAppend(Position position) {
  absl::MutexLock lock(&mutex_);
  under_way_.erase(position);
}

absl::StatusOr<Journal::Position> RocksJournal::Append(absl::string_view mission,
                                                       const JournalRecord& record) {
  const std::string bytes = map_store::EncodeRecord(record);
  RETURN_IF_ERROR(CheckRoom(bytes.size()));
  const Position position = BeginAppend();
  const std::string name(mission);
  rocksdb::WriteBatch batch;
  std::vector<KeyframeId> keyframes;
  if (const auto* update = std::get_if<BatchRecord>(&record)) {
    for (const FullKeyframe& keyframe : update->batch->full_keyframes) {
      const KeyframePayload& payload = *keyframe.payload;
      batch.Put(FeaturesKey(name, payload.id), map_store::EncodeFeatures(payload.features));
      keyframes.push_back(payload.id);
    }
  }
  batch.Put(RecordKey(name, position), bytes);
  bool is_listed = false;
  {
    absl::MutexLock lock(&mutex_);
    is_listed = FilesOf(mission).is_listed;
  }
  if (!is_listed) batch.Put(MissionKey(name), Encode(MissionHeader()));
  const absl::Status written = ToStatus(database_->Write(batch, false));
  EndAppend(position);
  RETURN_IF_ERROR(written);
  absl::MutexLock lock(&mutex_);
  MissionFiles& files = FilesOf(mission);
  files.is_listed = true;
  files.bytes_since_snapshot += bytes.size();
  for (const KeyframeId& id : keyframes) files.features[id] = position;
  return position;
}

absl::Status RocksJournal::Sync(Position position) {
  if (!options_.sync) return absl::OkStatus();
  absl::MutexLock lock(&mutex_);
  while (synced_ < position) {
    // One syncs for all that were appended by then; the others wait for it.
    if (syncing_) {
      synced_changed_.Wait(&mutex_);
      continue;
    }
    syncing_ = true;
    const Position written = under_way_.empty() ? last_ : *under_way_.begin() - 1;
    mutex_.Unlock();
    const absl::Status status = ToStatus(database_->SyncLog());
    mutex_.Lock();
    syncing_ = false;
    synced_changed_.SignalAll();
    RETURN_IF_ERROR(status);
    synced_ = std::max(synced_, written);
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
  }
  const std::vector<KeyframeId> unneeded = FindUnneeded(mission, snapshot);
  const uint64_t size = snapshot.state.size();
  rocksdb::WriteBatch turn;
  turn.Put(MissionKey(name), Encode(MissionHeader{snapshot.position, size}));
  const std::string records = MissionPrefix(JournalPart::kRecord, name);
  turn.DeleteRange(records, RecordKey(name, snapshot.position + 1));
  const std::string snapshots = MissionPrefix(JournalPart::kSnapshot, name);
  turn.DeleteRange(snapshots, SnapshotKey(name, snapshot.position, 0));
  for (const KeyframeId& id : unneeded) turn.Delete(FeaturesKey(name, id));
  RETURN_IF_ERROR(ToStatus(database_->Write(turn, true)));
  absl::MutexLock lock(&mutex_);
  MissionFiles& files = FilesOf(mission);
  files.snapshot_bytes = size;
  files.bytes_since_snapshot = 0;
  for (const KeyframeId& id : unneeded) files.features.erase(id);
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

absl::Status RocksJournal::DeleteMission(absl::string_view mission) {
  const std::string name(mission);
  rocksdb::WriteBatch batch;
  batch.Delete(MissionKey(name));
  for (const JournalPart part :
       {JournalPart::kRecord, JournalPart::kSnapshot, JournalPart::kFeatures}) {
    const std::string prefix = MissionPrefix(part, name);
    batch.DeleteRange(prefix, EndOfPrefix(prefix));
  }
  RETURN_IF_ERROR(ToStatus(database_->Write(batch, true)));
  absl::MutexLock lock(&mutex_);
  missions_.erase(name);
  return absl::OkStatus();
}

}  // namespace corbslam

#include "map_store/rocks/mission_journal.h"

#include <rocksdb/write_batch.h>

#include <algorithm>
#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/strings/str_cat.h"
#include "map_store/archive/state_archive.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kChunkBytes = 1 << 20;

// Calls `put` with the key and the bytes of each of the snapshot's chunks.
absl::Status ForEachChunk(
    const std::string& name, const JournalSnapshot& snapshot,
    absl::FunctionRef<absl::Status(const std::string& key, const std::string& chunk)> put) {
  uint32_t chunks = 0;
  for (size_t begin = 0; begin < snapshot.state.size(); begin += kChunkBytes) {
    RETURN_IF_ERROR(put(SnapshotKey(name, snapshot.position, chunks++),
                        snapshot.state.substr(begin, kChunkBytes)));
  }
  return absl::OkStatus();
}

// Adds what puts a snapshot in the place of all before it.
void AddTurn(const std::string& name, const JournalSnapshot& snapshot,
             const std::vector<KeyframeId>& unneeded, rocksdb::WriteBatch& turn) {
  turn.Put(MissionKey(name),
           Encode(MissionHeader{snapshot.position, static_cast<uint64_t>(snapshot.state.size())}));
  const std::string records = MissionPrefix(JournalPart::kRecord, name);
  turn.DeleteRange(records, RecordKey(name, snapshot.position + 1));
  const std::string snapshots = MissionPrefix(JournalPart::kSnapshot, name);
  turn.DeleteRange(snapshots, SnapshotKey(name, snapshot.position, 0));
  // This removes what another one at the same position may have left behind.
  const auto chunks =
      static_cast<uint32_t>((snapshot.state.size() + kChunkBytes - 1) / kChunkBytes);
  turn.DeleteRange(SnapshotKey(name, snapshot.position, chunks),
                   SnapshotKey(name, snapshot.position + 1, 0));
  for (const KeyframeId& id : unneeded) turn.Delete(FeaturesKey(name, id));
}

}  // namespace

MissionJournal::MissionJournal(std::string name, const RocksJournalOptions& options,
                               std::unique_ptr<RocksDatabase> database)
    : name_(std::move(name)), options_(options), database_(std::move(database)) {}

MissionJournal::~MissionJournal() { Close(); }

void MissionJournal::Close() {
  WriteMark();
  {
    absl::MutexLock marking(&marking_);
    closed_ = true;
  }
  database_->Close();
}

absl::Status MissionJournal::ToStatus(const rocksdb::Status& status) const {
  if (status.ok()) return absl::OkStatus();
  const std::string message =
      absl::StrCat("journal ", database_->directory(), ": ", status.ToString());
  if (status.IsNoSpace()) return absl::ResourceExhaustedError(message);
  if (status.IsCorruption()) return Note(absl::DataLossError(message));
  return absl::UnavailableError(message);
}

absl::Status MissionJournal::Note(absl::Status error) const {
  absl::MutexLock lock(&damage_mutex_);
  if (absl::IsDataLoss(error) && damage_.ok()) damage_ = error;
  return error;
}

absl::Status MissionJournal::Damage() const {
  absl::MutexLock lock(&damage_mutex_);
  return damage_;
}

absl::Status MissionJournal::WriteFormat() {
  rocksdb::WriteBatch batch;
  batch.Put(map_store::FormatKey(), EncodeFormat());
  return ToStatus(database_->Write(batch, true));
}

absl::Status MissionJournal::Begin() { return WriteFormat(); }

absl::Status MissionJournal::CheckWritable() {
  // The write repeats what is there already, to find out whether writing works.
  return database_->failed() ? WriteFormat() : absl::OkStatus();
}

Journal::Position MissionJournal::NextPosition() {
  absl::MutexLock lock(&mutex_);
  return ++last_;
}

absl::StatusOr<Journal::Position> MissionJournal::Append(const BatchBytes& bytes,
                                                         const std::vector<KeyframeId>& removed) {
  RETURN_IF_ERROR(Damage());
  rocksdb::WriteBatch batch;
  for (const auto& [id, features] : bytes.features) batch.Put(FeaturesKey(name_, id), features);
  const Position position = NextPosition();
  batch.Put(RecordKey(name_, position), bytes.record);
  bool is_marked = false;
  std::vector<BookedPicture> gone;
  {
    absl::MutexLock lock(&mutex_);
    is_marked = is_marked_;
    for (const KeyframeId& id : removed) {
      if (const auto picture = pictures_.Take(id)) gone.push_back(*picture);
    }
    may_be_wasteful_ |= !gone.empty();
  }
  AddRemovals(gone, batch);
  if (!is_marked) batch.Put(MissionKey(name_), Encode(MissionHeader()));
  RETURN_IF_ERROR(ToStatus(database_->Write(batch, false)));
  absl::MutexLock lock(&mutex_);
  is_marked_ = true;
  written_ = position;
  contents_.NoteRecord(position, bytes.record.size());
  for (const auto& [id, features] : bytes.features) {
    contents_.NoteFeatures(id, position, features.size());
  }
  for (const KeyframeId& id : removed) contents_.NoteRemoved(id, position);
  return position;
}

absl::Status MissionJournal::Sync(Position position) {
  if (!options_.sync) return absl::OkStatus();
  absl::MutexLock lock(&mutex_);
  // A position of an earlier mission of the name may be larger than all of this one's.
  while (synced_ < std::min(position, written_)) {
    // One thread syncs for all that were written by then; the others wait for it.
    if (syncing_) {
      synced_changed_.Wait(&mutex_);
      continue;
    }
    syncing_ = true;
    const Position written = written_;
    mutex_.Unlock();
    const absl::Status status = ToStatus(database_->SyncLog());
    mutex_.Lock();
    syncing_ = false;
    synced_changed_.SignalAll();
    RETURN_IF_ERROR(status);
    synced_ = written;
  }
  return absl::OkStatus();
}

bool MissionJournal::WantsSnapshot() const {
  absl::MutexLock lock(&mutex_);
  return contents_.WantsSnapshot(options_.min_bytes_between_snapshots);
}

absl::Status MissionJournal::WriteChunks(const JournalSnapshot& snapshot) {
  return ForEachChunk(name_, snapshot, [this](const std::string& key, const std::string& bytes) {
    rocksdb::WriteBatch chunk;
    chunk.Put(key, bytes);
    RETURN_IF_ERROR(ToStatus(database_->Write(chunk, false)));
    // Else the next record's sync would wait for the whole snapshot.
    return options_.sync ? ToStatus(database_->SyncLog()) : absl::OkStatus();
  });
}

absl::Status MissionJournal::WriteSnapshot(const JournalSnapshot& snapshot) {
  RETURN_IF_ERROR(Damage());
  RETURN_IF_ERROR(CheckRoom(options_, snapshot.state.size()));
  std::vector<KeyframeId> unneeded;
  std::vector<BookedPicture> gone;
  bool replaces_its_like = false;
  {
    absl::MutexLock lock(&mutex_);
    unneeded = contents_.FindUnneeded(snapshot);
    gone = pictures_.FindUnneeded(snapshot.position,
                                  {snapshot.keyframes.begin(), snapshot.keyframes.end()});
    replaces_its_like = contents_.snapshot_position() == snapshot.position;
  }
  rocksdb::WriteBatch turn;
  if (replaces_its_like) {
    // Its chunks have the keys of those that are valid until the turn: all change in one write.
    // There is no newer record, so that nobody waits for it.
    RETURN_IF_ERROR(
        ForEachChunk(name_, snapshot, [&turn](const std::string& key, const std::string& chunk) {
          turn.Put(key, chunk);
          return absl::OkStatus();
        }));
  } else {
    RETURN_IF_ERROR(WriteChunks(snapshot));
  }
  AddTurn(name_, snapshot, unneeded, turn);
  AddRemovals(gone, turn);
  RETURN_IF_ERROR(ToStatus(database_->Write(turn, true)));
  absl::MutexLock lock(&mutex_);
  is_marked_ = true;
  may_be_wasteful_ = true;
  contents_.NoteSnapshot(snapshot.position, snapshot.state.size(), unneeded);
  for (const BookedPicture& picture : gone) pictures_.Take(picture.keyframe);
  return absl::OkStatus();
}

absl::Status MissionJournal::Create(const MissionState& state) {
  rocksdb::WriteBatch mark;
  mark.Put(MissionKey(name_), Encode(MissionHeader{kIncomplete, 0}));
  RETURN_IF_ERROR(ToStatus(database_->Write(mark, false)));
  const Position position = NextPosition();
  RETURN_IF_ERROR(WriteFeatures(state, position));
  JournalSnapshot snapshot = map_store::TakeSnapshot(state);
  snapshot.position = position;
  RETURN_IF_ERROR(WriteSnapshot(snapshot));
  absl::MutexLock lock(&mutex_);
  written_ = synced_ = position;
  return absl::OkStatus();
}

absl::Status MissionJournal::WriteFeatures(const MissionState& state, Position position) {
  for (const auto& [id, local_map] : state.local_maps) {
    RETURN_IF_ERROR(CheckRoom(options_, local_map.stored_bytes));
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      const std::string features = map_store::EncodeFeatures(*keyframe.payload);
      rocksdb::WriteBatch batch;
      batch.Put(FeaturesKey(name_, keyframe_id), features);
      RETURN_IF_ERROR(ToStatus(database_->Write(batch, false)));
      absl::MutexLock lock(&mutex_);
      contents_.NoteFeatures(keyframe_id, position, features.size());
    }
  }
  return absl::OkStatus();
}

}  // namespace corbslam::map_store

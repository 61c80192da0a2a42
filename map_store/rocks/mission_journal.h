// Keeps what a journal has of one mission, in a database of its own: what is wrong with its files
// is this mission's alone, and its files go with it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_MISSION_JOURNAL_H_
#define CORBSLAM_MAP_STORE_ROCKS_MISSION_JOURNAL_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/records/journal.h"
#include "map_store/records/mission_contents.h"
#include "map_store/records/picture_book.h"
#include "map_store/rocks/backup_note.h"
#include "map_store/rocks/journal_options.h"
#include "map_store/rocks/log_file_check.h"

namespace rocksdb {
class DB;
class Status;
class WriteBatch;
}  // namespace rocksdb

namespace corbslam::map_store {
class RocksDatabase;

// Does for one mission what Journal says; all errors name its folder. Thread-safe.
class MissionJournal {
 public:
  using Position = Journal::Position;

  // `database` is open.
  MissionJournal(std::string name, const RocksJournalOptions& options,
                 std::unique_ptr<RocksDatabase> database);
  ~MissionJournal();

  // Says of a database that was just made that it is a mission's; that lasts when the function
  // returns.
  absl::Status Begin();
  // Finds out what is there; called before all else but Begin. Returns DATA_LOSS for what can't be
  // read, NOT_FOUND if there is no mission, or not all of one: nobody was ever told that there is.
  absl::Status Load();
  // Does so but for features, for who only looks for damage.
  absl::Status LoadRecordsOnly();

  absl::StatusOr<Position> Append(const BatchBytes& bytes, const std::vector<KeyframeId>& removed);
  absl::Status Sync(Position position);
  bool WantsSnapshot() const;
  absl::Status WriteSnapshot(const JournalSnapshot& snapshot);
  absl::Status Create(const MissionState& state);
  absl::StatusOr<Position> Recover(const Journal::Replay& replay) const;
  absl::Status CheckWritable();

  absl::Status PutPicture(const KeyframePicture& picture, uint64_t max_bytes);
  absl::StatusOr<KeyframePicture> ReadPicture(KeyframeId keyframe) const;
  absl::Status ForEachPicture(
      const std::function<absl::Status(const KeyframePicture& picture)>& visit) const;

  // Returns DATA_LOSS, with what is wrong and what to do, once something was found damaged.
  absl::Status Damage() const;
  uint64_t DiskBytes() const;
  // Gives back to the disk what is needed no more, if that is much, and to memory what nobody has
  // written to for a while. Somebody should call this now and then, on a thread of its own.
  absl::Status Tidy(absl::Time now);
  // Puts all into tables and gives back to the disk what is needed no more, whenever that was
  // written, for a mission that nobody writes to.
  absl::Status Settle();
  // Compares all files with their checksums, and decodes all that is in them.
  absl::Status Verify() const;
  // Returns how much of the mission was written; nothing but writing changes it.
  absl::StatusOr<DatabaseMark> Mark() const;
  // Gives the mission's database to `use` (RocksDatabase::Lend); DATA_LOSS if it is damaged.
  absl::Status Lend(
      const std::function<rocksdb::Status(rocksdb::DB& db, const std::function<bool()>& goes_on)>&
          use) const;
  // Looks at what only opening reads: the logs and the list of files. DATA_LOSS, which is
  // remembered, names the file.
  absl::Status ScrubLogs(const ReadPace& pace) const;
  // Reads what lies from the key `from` on, about `max_bytes`, and sets `from` to where to go on;
  // empty: that was all. DATA_LOSS, which is remembered, for what does not fit its checksum.
  // Returns how many bytes were read.
  absl::StatusOr<uint64_t> Scrub(uint64_t max_bytes, std::string& from) const;
  const std::string& name() const { return name_; }
  // Ends all that goes on with the files. From here on everything fails.
  void Close() ABSL_LOCKS_EXCLUDED(marking_);

 private:
  // Returns DATA_LOSS if less is there than was durable once.
  absl::Status CheckMark() ABSL_LOCKS_EXCLUDED(marking_, mutex_);
  void WriteMark() ABSL_LOCKS_EXCLUDED(marking_, mutex_);
  absl::Status LoadRecords(Position snapshot_position);
  absl::Status LoadFeatures();
  absl::Status LoadPictures();
  // Adds to the write that these pictures go.
  void AddRemovals(const std::vector<BookedPicture>& gone, rocksdb::WriteBatch& batch) const;
  absl::StatusOr<Features> ReadFeatures(KeyframeId id) const;
  // Returns null where the replay wants no features.
  FeatureLoader LoaderFor(const Journal::Replay& replay) const;
  absl::Status ReplaySnapshot(Position position, const Journal::Replay& replay) const;
  // Replays the records after `position`, and sets it to the last one's.
  absl::Status ReplayRecords(const Journal::Replay& replay, Position& position) const;
  // Reads the format's number; an older one becomes the present one, unless nothing is written
  // here.
  absl::Status TakeFormat(const std::string& bytes, const std::string& place);
  absl::Status WriteFormat();
  absl::Status WriteChunks(const JournalSnapshot& snapshot);
  absl::Status WriteFeatures(const MissionState& state, Position position);
  Position NextPosition() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether much of the disk is taken by what is needed no more.
  bool IsWasteful() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Remembers that something was deleted, or that nothing is left of it.
  void SetMayBeWasteful(bool may_be) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status TidyMemory(absl::Time now);
  absl::Status TidyDisk();
  absl::Status CheckRoomToTidy() const ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status ToStatus(const rocksdb::Status& status) const;
  absl::Status ToReadStatus(const rocksdb::Status& status) const;
  // Returns the error; if it is one of damage, it is remembered.
  absl::Status Note(absl::Status error) const ABSL_LOCKS_EXCLUDED(damage_mutex_);

  const std::string name_;
  const RocksJournalOptions options_;
  const std::unique_ptr<RocksDatabase> database_;

  mutable absl::Mutex damage_mutex_;
  mutable absl::Status damage_ ABSL_GUARDED_BY(damage_mutex_);

  absl::Mutex marking_ ABSL_ACQUIRED_BEFORE(mutex_);
  Position marked_ ABSL_GUARDED_BY(marking_) = 0;  // What DURABLE says.
  // The folder may be another mission's by now.
  bool closed_ ABSL_GUARDED_BY(marking_) = false;

  mutable absl::Mutex mutex_;
  absl::CondVar synced_changed_;
  // Replays find out which keyframes were removed.
  mutable MissionContents contents_ ABSL_GUARDED_BY(mutex_);
  PictureBook pictures_ ABSL_GUARDED_BY(mutex_);
  bool is_marked_ ABSL_GUARDED_BY(mutex_) = false;  // Whether it has a header.
  Position last_ ABSL_GUARDED_BY(mutex_) = 0;
  // The last records that were written, and that are durable.
  Position written_ ABSL_GUARDED_BY(mutex_) = 0;
  Position synced_ ABSL_GUARDED_BY(mutex_) = 0;
  bool syncing_ ABSL_GUARDED_BY(mutex_) = false;
  // Whether something was deleted since the files were tidied up.
  bool may_be_wasteful_ ABSL_GUARDED_BY(mutex_) = true;
  // The last record when memory was looked at, and since when it has been the last.
  Position looked_at_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Time unchanged_since_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_MISSION_JOURNAL_H_

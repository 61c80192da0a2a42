// Keeps the journal in a folder of its own, with RocksDB in the store's process. docs/journal.md
// says what is in it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_ROCKS_JOURNAL_H_
#define CORBSLAM_MAP_STORE_ROCKS_ROCKS_JOURNAL_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/journal.h"

namespace rocksdb {
class Env;
class Status;
}  // namespace rocksdb

namespace corbslam::map_store {
class RocksDatabase;

struct RocksJournalOptions {
  std::string directory;
  // A mission gets a snapshot when its records since the last one are larger than this and than
  // that snapshot.
  uint64_t min_bytes_between_snapshots = 32 << 20;
  // So many bytes of the disk are left free: with less, records and snapshots are refused. The
  // database needs them to tidy up, and to write a mission's deletion.
  uint64_t min_free_bytes = 64 << 20;
  // False: Sync returns at once, for measurements, and to show that tests of durability would fail.
  bool sync = true;
  // Not owned; null: the system's. Tests put a faulty one here.
  rocksdb::Env* env = nullptr;
};

class RocksJournal : public Journal {
 public:
  // Opens the journal and creates the folder where it is not there. FAILED_PRECONDITION: it was
  // written in another format, is no journal, or another process has it open. DATA_LOSS: it is
  // damaged. Each error names the folder.
  static absl::StatusOr<std::unique_ptr<RocksJournal>> Open(const RocksJournalOptions& options);
  ~RocksJournal() override;

  void Prepare(BatchRecord& record) const override;
  void Prepare(AdjustRecord& record) const override;
  absl::StatusOr<Position> Append(absl::string_view mission, const JournalRecord& record) override;
  absl::Status Sync(Position position) override;
  bool WantsSnapshot(absl::string_view mission) const override;
  absl::Status WriteSnapshot(absl::string_view mission, const JournalSnapshot& snapshot) override;
  absl::Status CreateMission(absl::string_view mission, const MissionState& state) override;
  absl::StatusOr<std::vector<std::string>> ListMissions() const override;
  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override;
  absl::Status DeleteMission(absl::string_view mission) override;
  absl::Status CheckWritable() override;

 private:
  // Says what was written of a mission.
  struct MissionFiles {
    bool is_listed = false;
    uint64_t snapshot_bytes = 0;
    // Bytes of each record since the snapshot.
    std::map<Position, uint64_t> records;
    uint64_t bytes_since_snapshot = 0;
    // Keyframes whose features are stored, and the last record that brought them.
    std::map<KeyframeId, Position> features;
  };

  RocksJournal(const RocksJournalOptions& options, std::unique_ptr<RocksDatabase> database);

  absl::Status LoadMissions();
  absl::Status LoadMission(const std::string& name) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<Features> LoadFeatures(const std::string& mission, KeyframeId id) const;
  // Returns null where the replay wants no features.
  std::function<absl::StatusOr<Features>(KeyframeId)> LoaderFor(const std::string& mission,
                                                                const Replay& replay) const;
  absl::Status ReplaySnapshot(const std::string& mission, Position position,
                              const Replay& replay) const;
  // Replays the records after `position`, and sets it to the last one's.
  absl::Status ReplayRecords(const std::string& mission, const Replay& replay,
                             Position& position) const;
  absl::Status Erase(const std::string& mission);
  absl::Status WriteFeatures(const std::string& mission, const MissionState& state,
                             Position position);
  absl::Status WriteFormat();
  // Returns RESOURCE_EXHAUSTED when less than min_free_bytes would be left.
  absl::Status CheckRoom(uint64_t bytes) const;
  // Checks the same, and remembers the size of a record that had no room until there is room for
  // one.
  absl::Status CheckRoomForRecord(uint64_t bytes);
  Position NextPosition() ABSL_LOCKS_EXCLUDED(mutex_);
  static void NoteRecord(Position position, uint64_t bytes, MissionFiles& files);
  static void ForgetRecords(Position until, MissionFiles& files);
  MissionFiles& FilesOf(absl::string_view mission) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::vector<KeyframeId> FindUnneeded(absl::string_view mission, const JournalSnapshot& snapshot)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status ToStatus(const rocksdb::Status& status) const;

  const RocksJournalOptions options_;
  const std::unique_ptr<RocksDatabase> database_;

  std::atomic<uint64_t> record_without_room_ = 0;

  mutable absl::Mutex mutex_;
  absl::CondVar synced_changed_;
  std::map<std::string, MissionFiles, std::less<>> missions_ ABSL_GUARDED_BY(mutex_);
  Position last_ ABSL_GUARDED_BY(mutex_) = 0;
  // Records that were written since the last sync began, and records that this sync makes durable.
  std::set<Position> unsynced_ ABSL_GUARDED_BY(mutex_);
  std::set<Position> being_synced_ ABSL_GUARDED_BY(mutex_);
  bool syncing_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_ROCKS_JOURNAL_H_

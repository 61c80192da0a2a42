// The journal in a folder of its own, kept by RocksDB in the store's process. docs/journal.md says
// what is in it.
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

namespace corbslam {
namespace map_store {
class RocksDatabase;
}  // namespace map_store

struct RocksJournalOptions {
  std::string directory;
  // A mission gets a snapshot when its records since the last one are larger than this and than
  // that snapshot.
  uint64_t min_bytes_between_snapshots = 32 << 20;
  // Left free on the disk: with less, records and snapshots are refused. It is what the database
  // needs to tidy up, and a mission's deletion to be written.
  uint64_t min_free_bytes = 64 << 20;
  // False: Sync returns at once. For measurements, and to show that tests of durability would fail.
  bool sync = true;
  // Not owned; null: the system's. Tests put a faulty one here.
  rocksdb::Env* env = nullptr;
};

class RocksJournal : public Journal {
 public:
  // Creates the folder where it is not there. FAILED_PRECONDITION: written in another format, or
  // not a journal, or another process has it open. DATA_LOSS: damaged. Each names the folder.
  static absl::StatusOr<std::unique_ptr<RocksJournal>> Open(const RocksJournalOptions& options);
  ~RocksJournal() override;

  absl::StatusOr<Position> Append(absl::string_view mission,
                                  const map_store::JournalRecord& record) override;
  absl::Status Sync(Position position) override;
  bool WantsSnapshot(absl::string_view mission) const override;
  absl::Status WriteSnapshot(absl::string_view mission, const JournalSnapshot& snapshot) override;
  absl::Status CreateMission(absl::string_view mission,
                             const map_store::MissionState& state) override;
  absl::StatusOr<std::vector<std::string>> ListMissions() const override;
  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override;
  absl::Status DeleteMission(absl::string_view mission) override;
  absl::Status CheckWritable() override;

 private:
  // What was written of a mission.
  struct MissionFiles {
    bool is_listed = false;
    uint64_t snapshot_bytes = 0;
    std::map<Position, uint64_t> records;  // Bytes of each since the snapshot.
    uint64_t bytes_since_snapshot = 0;
    // Keyframes whose features are stored, and the last record that brought them.
    std::map<KeyframeId, Position> features;
  };

  RocksJournal(const RocksJournalOptions& options,
               std::unique_ptr<map_store::RocksDatabase> database);

  absl::Status LoadMissions();
  absl::Status LoadMission(const std::string& name) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<Features> LoadFeatures(const std::string& mission, KeyframeId id) const;
  // Null where the replay wants none.
  std::function<absl::StatusOr<Features>(KeyframeId)> LoaderFor(const std::string& mission,
                                                                const Replay& replay) const;
  absl::Status ReplaySnapshot(const std::string& mission, Position position,
                              const Replay& replay) const;
  // Those behind `position`; which becomes the last one's.
  absl::Status ReplayRecords(const std::string& mission, const Replay& replay,
                             Position& position) const;
  absl::Status Erase(const std::string& mission);
  absl::Status WriteFeatures(const std::string& mission, const map_store::MissionState& state,
                             Position position);
  absl::Status WriteFormat();
  // RESOURCE_EXHAUSTED when less than min_free_bytes would be left.
  absl::Status CheckRoom(uint64_t bytes) const;
  // And remembers, until there was room for one, how large a record had none.
  absl::Status CheckRoomForRecord(uint64_t bytes);
  Position NextPosition() ABSL_LOCKS_EXCLUDED(mutex_);
  static void NoteRecord(Position position, uint64_t bytes, MissionFiles& files);
  static void ForgetRecords(Position until, MissionFiles& files);
  MissionFiles& FilesOf(absl::string_view mission) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::vector<KeyframeId> FindUnneeded(absl::string_view mission, const JournalSnapshot& snapshot)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status ToStatus(const rocksdb::Status& status) const;

  const RocksJournalOptions options_;
  const std::unique_ptr<map_store::RocksDatabase> database_;

  std::atomic<uint64_t> record_without_room_ = 0;

  mutable absl::Mutex mutex_;
  absl::CondVar synced_changed_;
  std::map<std::string, MissionFiles, std::less<>> missions_ ABSL_GUARDED_BY(mutex_);
  Position last_ ABSL_GUARDED_BY(mutex_) = 0;
  // Records that were written since the last sync began, and those that it makes durable.
  std::set<Position> unsynced_ ABSL_GUARDED_BY(mutex_);
  std::set<Position> being_synced_ ABSL_GUARDED_BY(mutex_);
  bool syncing_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam

#endif  // CORBSLAM_MAP_STORE_ROCKS_ROCKS_JOURNAL_H_

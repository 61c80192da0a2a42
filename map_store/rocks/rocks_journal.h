// Keeps the journal in a folder of its own, with a RocksDB for each mission in the store's process.
// docs/journal.md says what is in it.
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
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_options.h"

namespace rocksdb {
class Cache;
class DB;
class Status;
}  // namespace rocksdb

namespace corbslam::map_store {
class JournalScrubber;
class JournalTidier;
class MissionJournal;
class RocksDatabase;
struct FilesCheck;
struct DatabaseMark;
struct ScrubCounts;

class RocksJournal : public Journal {
 public:
  // Opens the journal and creates the folder where it is not there. FAILED_PRECONDITION: it was
  // written in another format, is no journal, or another process has it open. DATA_LOSS: what is
  // damaged is not one mission's. Each error names the folder. A mission whose files can't be read
  // is there, and damaged (Damage).
  static absl::StatusOr<std::unique_ptr<RocksJournal>> Open(const RocksJournalOptions& options);
  ~RocksJournal() override;

  void Prepare(BatchRecord& record) const override;
  void Prepare(AdjustRecord& record) const override;
  absl::StatusOr<Position> Append(absl::string_view mission, const JournalRecord& record) override;
  absl::Status Sync(absl::string_view mission, Position position) override;
  bool WantsSnapshot(absl::string_view mission) const override;
  absl::Status WriteSnapshot(absl::string_view mission, const JournalSnapshot& snapshot) override;
  absl::Status CreateMission(absl::string_view mission, const MissionState& state) override;
  absl::StatusOr<std::vector<std::string>> ListMissions() const override;
  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override;
  absl::Status DeleteMission(absl::string_view mission) override;
  absl::Status NoteInList(MissionList list, const MissionIdentity& mission) override;
  std::vector<MissionIdentity> ReadList(MissionList list) const override;
  void TidyUp(absl::string_view mission) override;
  absl::Status PutAside(absl::string_view mission, absl::string_view summary) override;
  absl::StatusOr<std::string> ReadSummary(absl::string_view mission) const override;
  absl::Status PutPicture(absl::string_view mission, const KeyframePicture& picture,
                          uint64_t max_bytes) override;
  absl::StatusOr<KeyframePicture> ReadPicture(absl::string_view mission,
                                              KeyframeId keyframe) const override;
  absl::Status ForEachPicture(
      absl::string_view mission,
      const std::function<absl::Status(const KeyframePicture& picture)>& visit) const override;
  absl::Status CheckWritable() override;
  absl::Status Damage(absl::string_view mission) const override;
  uint64_t DiskBytes(absl::string_view mission) const override;

  // Compares the mission's files with their checksums. DATA_LOSS names what is damaged.
  absl::Status Verify(absl::string_view mission) const;
  // These do what those of MissionJournal do; NOT_FOUND: the journal has nothing of the mission.
  absl::StatusOr<DatabaseMark> Mark(absl::string_view mission) const;
  absl::Status Lend(
      absl::string_view mission,
      const std::function<rocksdb::Status(rocksdb::DB& db, const std::function<bool()>& goes_on)>&
          use) const;
  // Looks at the files of a mission of a folder that is only read, beside the database (Verify).
  FilesCheck CheckFiles(absl::string_view mission) const;
  // Returns what was read to find damage (scrub_bytes_per_s).
  ScrubCounts scrub_counts() const;
  // Reads all missions once to find damage, here and now.
  void ScrubNow();
  const RocksJournalOptions& options() const { return options_; }

 private:
  using MissionPtr = std::shared_ptr<MissionJournal>;

  explicit RocksJournal(const RocksJournalOptions& options);
  // Says why a mission's database can't be opened; DATA_LOSS: because of what is in its files.
  static absl::Status OpenFailure(const std::string& path, const rocksdb::Status& status);

  // Opens the database that guards the folder, and finds the missions. The guard keeps other
  // processes out, and programs that would take the folder for an empty one.
  absl::Status OpenGuard();
  // Keeps what an older program wrote, and says where.
  absl::Status KeepOlder(uint32_t format);
  // Passes the guard for who only reads: keeps others out as far as that goes, refuses formats that
  // are not read, and makes nothing.
  absl::Status PassGuard();
  absl::Status MakeGuard();
  absl::Status WriteGuard();
  absl::StatusOr<uint32_t> ReadGuard();
  absl::Status LoadMissions();
  absl::Status LoadMission(const std::string& name);
  absl::StatusOr<MissionPtr> OpenMission(const std::string& name) const;
  absl::Status MakeFolder(const std::string& name) const;
  // Makes the mission's database, if there is none.
  absl::StatusOr<MissionPtr> MakeMission(absl::string_view name)
      ABSL_LOCKS_EXCLUDED(making_, mutex_);
  absl::StatusOr<MissionPtr> FindMission(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsAside(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Opens a mission that is aside.
  absl::StatusOr<MissionPtr> BringBack(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  // For the scrubber (JournalScrubber::Access).
  void StartScrubber();
  absl::StatusOr<MissionPtr> OpenAside(const std::string& name,
                                       const std::function<bool(uint64_t bytes)>& pace)
      ABSL_LOCKS_EXCLUDED(mutex_);
  bool NoteAside(const std::string& name, const absl::Status& damage) ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<MissionPtr> OpenMissions() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Checks for room, and remembers the size of a record that had none until there is room for one.
  absl::Status CheckRoomForRecord(uint64_t bytes);

  const RocksJournalOptions options_;
  const JournalFolder folder_;
  const std::shared_ptr<rocksdb::Cache> cache_;
  std::unique_ptr<RocksDatabase> guard_;

  std::atomic<uint64_t> record_without_room_ = 0;

  // Held while a mission's database is made or removed.
  absl::Mutex making_ ABSL_ACQUIRED_BEFORE(mutex_);
  mutable absl::Mutex mutex_;
  // Whoever reads a mission that is aside opens it.
  mutable std::map<std::string, MissionPtr, std::less<>> missions_ ABSL_GUARDED_BY(mutex_);
  mutable std::set<std::string, std::less<>> aside_ ABSL_GUARDED_BY(mutex_);
  // What was found of missions that are aside; waking them has the last word.
  mutable std::map<std::string, absl::Status, std::less<>> aside_damage_ ABSL_GUARDED_BY(mutex_);
  // What CURRENT said of those that the scrubber has begun to read.
  std::map<std::string, std::string, std::less<>> aside_lists_ ABSL_GUARDED_BY(mutex_);
  // Missions that can't be opened, and why.
  mutable std::map<std::string, absl::Status, std::less<>> unreadable_ ABSL_GUARDED_BY(mutex_);

  std::unique_ptr<JournalTidier> tidier_;
  std::unique_ptr<JournalScrubber> scrubber_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_ROCKS_JOURNAL_H_

// Keeps the journal in a database that speaks PostgreSQL's protocol. docs/fleet.md says how to set
// one up, docs/adr/0044-journal-on-postgresql.md why it is as it is.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_JOURNAL_H_
#define CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_JOURNAL_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/postgres/mission_row.h"
#include "map_store/postgres/postgres_options.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {
class PostgresMission;
class SqlPool;

class PostgresJournal : public Journal {
 public:
  // Connects, and finds the missions. INVALID_ARGUMENT: the URI. UNAVAILABLE: no server, or none
  // that writes. FAILED_PRECONDITION: the tables are not there, or not such that this program works
  // with them. Each error names the database.
  static absl::StatusOr<std::unique_ptr<PostgresJournal>> Open(
      const PostgresJournalOptions& options);
  ~PostgresJournal() override;

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

 private:
  using MissionPtr = std::shared_ptr<PostgresMission>;

  PostgresJournal(const PostgresJournalOptions& options, std::unique_ptr<SqlPool> pool);

  absl::Status FindMissions();
  absl::Status ReadLists();
  absl::StatusOr<MissionPtr> Find(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  MissionPtr FindOrBegin(absl::string_view name) ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<MissionPtr> All() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Writes what waits too long, removes the rows of deleted missions, and says that this process
  // lives.
  void Tend() ABSL_LOCKS_EXCLUDED(mutex_);
  void FlushWaiting() ABSL_LOCKS_EXCLUDED(mutex_);
  void Sweep() ABSL_LOCKS_EXCLUDED(mutex_);
  // Holds the missions for `lease` from now on; zero: lets go of them.
  void Hold(absl::Duration lease);

  const PostgresJournalOptions options_;
  const std::unique_ptr<SqlPool> pool_;
  const MissionHolder holder_;

  mutable absl::Mutex mutex_;
  std::map<std::string, MissionPtr, std::less<>> missions_ ABSL_GUARDED_BY(mutex_);
  std::map<MissionList, std::vector<MissionIdentity>> lists_ ABSL_GUARDED_BY(mutex_);
  bool has_waiting_ ABSL_GUARDED_BY(mutex_) = false;
  bool has_deleted_ ABSL_GUARDED_BY(mutex_) = true;
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;

  std::thread tender_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_JOURNAL_H_

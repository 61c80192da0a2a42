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
#include "map_store/fleet/lease_rules.h"
#include "map_store/postgres/fleet_directory.h"
#include "map_store/postgres/mission_row.h"
#include "map_store/postgres/postgres_options.h"
#include "map_store/records/journal.h"
#include "map_store/records/mission_leases.h"

namespace corbslam::map_store {
class PostgresMission;
class SqlPool;

// Returns what time it is by a clock that nobody sets, since some moment.
absl::Time SteadyNow();

// Without a lease (PostgresJournalOptions::lease) this process has all missions that the database
// has when it is opened, and those that it makes. With one it has those that it takes.
class PostgresJournal : public Journal, public MissionLeases {
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
  MissionLeases* leases() override { return is_shared() ? this : nullptr; }
  absl::StatusOr<std::vector<MissionIdentity>> ReadListOf(MissionList list,
                                                          absl::string_view name) const override;

  absl::Status Announce(const DirectoryStore& self) override;
  absl::StatusOr<std::vector<DirectoryStore>> ListStores() const override {
    return fleet_.ListStores();
  }
  absl::StatusOr<DirectoryMission> Look(absl::string_view mission) const override {
    return fleet_.Look(mission);
  }
  absl::StatusOr<std::vector<DirectoryMission>> List(absl::string_view after,
                                                     size_t count) const override {
    return fleet_.List(after, count);
  }
  void LetGo(absl::string_view mission) override;
  std::map<std::string, absl::Status> TakeLost() override;
  std::map<std::string, DirectoryStore> ListMoves() const override;
  absl::Status GiveTo(absl::string_view mission, const std::string& store) override;
  absl::StatusOr<DirectoryStore> FindTaker(const DirectoryMission& mission) const override;
  void NoteLoad(const WeighedStore& load) override;
  FleetCounts counts() const override;
  absl::Status CheckReached() const override;
  absl::Duration lease() const override { return options_.lease; }

 private:
  using MissionPtr = std::shared_ptr<PostgresMission>;

  PostgresJournal(const PostgresJournalOptions& options, std::unique_ptr<SqlPool> pool);

  absl::Status FindMissions();
  absl::Status ReadLists();
  bool is_shared() const { return options_.lease > absl::ZeroDuration(); }
  // Returns a mission that this process knows; null: it knows none of that name.
  MissionPtr FindKnown(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  // The same; NOT_FOUND.
  absl::StatusOr<MissionPtr> FindHere(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Looks in the database, too, where another process may have made it.
  absl::StatusOr<MissionPtr> Find(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<MissionPtr> FindShared(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the mission, if it was known.
  MissionPtr Forget(absl::string_view name) ABSL_LOCKS_EXCLUDED(mutex_);
  MissionPtr FindOrBegin(absl::string_view name) ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<MissionPtr> All() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Writes what waits too long, removes the rows of deleted missions, and says that this process
  // lives.
  void Tend() ABSL_LOCKS_EXCLUDED(mutex_);
  void FlushWaiting() ABSL_LOCKS_EXCLUDED(mutex_);
  void Sweep() ABSL_LOCKS_EXCLUDED(mutex_);
  // Holds the missions that this process has for a lease from now on, and finds out which it has
  // lost. Nobody calls it while it runs.
  void Renew() ABSL_LOCKS_EXCLUDED(mutex_);
  // What the directory says as leases are prolonged.
  struct Renewed {
    // By the number of a row that this process has: the store that is to have it.
    std::map<int64_t, std::string> wanted = {};
    // Likewise: since it came here from another store.
    std::map<int64_t, absl::Duration> since_moved = {};
    bool is_replaced = false;
    StoreDuty duty = StoreDuty::kTakesMissions;
  };
  absl::StatusOr<Renewed> RenewRows(const DirectoryStore& self);
  SqlStatement SayAlive(const DirectoryStore& self) const;
  // Finds out which missions are another one's. Returns false if the database did not say.
  static bool FindLost(const std::vector<MissionPtr>& held, const Renewed& still);
  void FindMoves(const std::vector<MissionPtr>& held, const DirectoryStore& self,
                 const Renewed& renewed) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the mission that is to go to another store to balance loads, with that store.
  std::map<std::string, DirectoryStore> FindBalancingMove(
      const std::vector<MissionPtr>& held, const DirectoryStore& self, const Renewed& renewed,
      const std::vector<DirectoryStore>& stores) const ABSL_LOCKS_EXCLUDED(mutex_);
  void CountStandbys() ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends all leases of this process.
  void EndLeases() ABSL_LOCKS_EXCLUDED(mutex_);

  const PostgresJournalOptions options_;
  const std::unique_ptr<SqlPool> pool_;
  const MissionHolder holder_;
  const FleetDirectory fleet_;

  mutable absl::Mutex mutex_;
  mutable std::map<std::string, MissionPtr, std::less<>> missions_ ABSL_GUARDED_BY(mutex_);
  std::map<MissionList, std::vector<MissionIdentity>> lists_ ABSL_GUARDED_BY(mutex_);
  bool has_waiting_ ABSL_GUARDED_BY(mutex_) = false;
  bool has_deleted_ ABSL_GUARDED_BY(mutex_) = true;
  bool stops_ ABSL_GUARDED_BY(mutex_) = false;
  // Of a shared journal.
  DirectoryStore self_ ABSL_GUARDED_BY(mutex_);  // Without a name: not announced.
  OwnLease own_lease_ ABSL_GUARDED_BY(mutex_);
  // Another process has begun as this store.
  bool is_replaced_ ABSL_GUARDED_BY(mutex_) = false;
  StoreDuty duty_ ABSL_GUARDED_BY(mutex_) = StoreDuty::kTakesMissions;
  std::map<std::string, DirectoryStore> moves_ ABSL_GUARDED_BY(mutex_);
  // The one of moves_ that balances loads; empty: there is none.
  std::string balancing_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, MissionWeight> weights_ ABSL_GUARDED_BY(mutex_);
  FleetCounts counts_ ABSL_GUARDED_BY(mutex_);
  // Missions whose lease is still to be ended.
  std::vector<MissionPtr> to_release_ ABSL_GUARDED_BY(mutex_);

  std::thread tender_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_JOURNAL_H_

// Implements the part of PostgresJournal that shares missions with other processes.
#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/postgres/postgres_journal.h"
#include "map_store/postgres/postgres_mission.h"
#include "map_store/postgres/sql_pool.h"
#include "slam/util/program_version.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr char kAnnounce[] =
    "INSERT INTO corbslam.stores (name, holder, address, machine, version, lease_until, started_at)"
    " VALUES ($1, $2, $3, $4, $5, clock_timestamp() + $6 * interval '1 millisecond',"
    " clock_timestamp()) ON CONFLICT (name) DO UPDATE SET holder = excluded.holder,"
    " address = excluded.address, machine = excluded.machine, version = excluded.version,"
    " lease_until = excluded.lease_until, started_at = excluded.started_at";

}  // namespace

absl::Status PostgresJournal::Announce(const DirectoryStore& self) {
  const SqlValue name = SqlValue::Text(self.name);
  RETURN_IF_ERROR(
      pool_
          ->WriteAgain({{"UPDATE corbslam.missions SET lease_until = NULL WHERE holder IN"
                         " (SELECT holder FROM corbslam.stores WHERE name = $1) AND holder <> $2",
                         {name, SqlValue::Number(holder_.id)}},
                        {kAnnounce,
                         {name, SqlValue::Number(holder_.id), SqlValue::Text(self.address),
                          SqlValue::Text(self.machine), SqlValue::Text(self.version),
                          holder_.LeaseMilliseconds()}},
                        // Stores that went long ago, and are nobody's to remember.
                        {"DELETE FROM corbslam.stores WHERE cordoned = 0 AND (lease_until IS NULL"
                         " OR lease_until < clock_timestamp() - interval '7 days')"
                         " AND started_at < clock_timestamp() - interval '7 days'"}})
          .status());
  absl::MutexLock lock(&mutex_);
  self_ = self;
  is_replaced_ = false;
  return absl::OkStatus();
}

absl::StatusOr<PostgresJournal::MissionPtr> PostgresJournal::FindShared(
    absl::string_view name) const {
  int64_t row_id = 0;
  ASSIGN_OR_RETURN(const DirectoryMission listed, fleet_.Look(name, &row_id));
  absl::MutexLock lock(&mutex_);
  MissionPtr& known = missions_[listed.name];
  // Another thread may have looked, too.
  if (known == nullptr) {
    known = std::make_shared<PostgresMission>(
        listed.name, options_, pool_.get(), holder_,
        PostgresMission::Known{row_id, true, listed.is_asleep, listed.bytes});
  }
  return known;
}

absl::StatusOr<std::vector<MissionIdentity>> PostgresJournal::ReadListOf(
    MissionList list, absl::string_view name) const {
  if (!is_shared()) return ReadList(list);
  ASSIGN_OR_RETURN(const std::vector<SqlResult> read,
                   pool_->Read({{"SELECT name, uid FROM corbslam.mission_lists WHERE list = $1"
                                 " AND name = $2 ORDER BY noted_at, entry_id",
                                 {SqlValue::Number(static_cast<int64_t>(list)),
                                  SqlValue::Text(std::string(name))}}}));
  std::vector<MissionIdentity> missions;
  for (int i = 0; i < read.front().rows(); ++i) {
    missions.push_back({read.front().Text(i, 0), read.front().Text(i, 1)});
  }
  return missions;
}

PostgresJournal::MissionPtr PostgresJournal::Forget(absl::string_view name) {
  absl::MutexLock lock(&mutex_);
  const auto it = missions_.find(std::string_view(name.data(), name.size()));
  if (it == missions_.end()) return nullptr;
  MissionPtr mission = std::move(it->second);
  missions_.erase(it);
  moves_.erase(mission->name());
  return mission;
}

absl::Status PostgresJournal::GiveTo(absl::string_view name, const std::string& store) {
  const MissionPtr mission = FindKnown(name);
  if (mission == nullptr) return absl::NotFoundError(std::string(name));
  RETURN_IF_ERROR(mission->FlushOlderThan(absl::InfiniteFuture()));
  RETURN_IF_ERROR(mission->Release(store));
  Forget(name);
  absl::MutexLock lock(&mutex_);
  ++counts_.given;
  counts_.given_to_balance += balancing_ == mission->name() ? 1 : 0;
  return absl::OkStatus();
}

void PostgresJournal::LetGo(absl::string_view name) {
  MissionPtr mission = Forget(name);
  if (mission == nullptr) return;
  if (absl::IsFailedPrecondition(mission->Failure())) {
    absl::MutexLock lock(&mutex_);
    ++counts_.lost;
  }
  const absl::Status released = mission->Release();
  if (released.ok()) return;
  LOG(WARNING) << "the lease of mission " << name << " is not ended yet: " << released;
  absl::MutexLock lock(&mutex_);
  to_release_.push_back(std::move(mission));
}

std::map<std::string, absl::Status> PostgresJournal::TakeLost() {
  std::map<std::string, absl::Status> lost;
  absl::MutexLock lock(&mutex_);
  for (const auto& [name, mission] : missions_) {
    absl::Status failure = mission->Failure();
    if (absl::IsFailedPrecondition(failure)) lost[name] = std::move(failure);
  }
  return lost;
}

absl::Status PostgresJournal::CheckReached() const {
  absl::MutexLock lock(&mutex_);
  if (is_replaced_) {
    return absl::UnavailableError(absl::StrCat(
        pool_->name(), ": another process has begun as store ", self_.name,
        " and takes its missions: this one is to end, or to have an address of its own"));
  }
  if (!own_lease_.IsOver(SteadyNow())) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(
      pool_->name(), ": it was not reached for the ", absl::FormatDuration(options_.lease),
      " of a lease: another store may have this one's missions by now"));
}

absl::StatusOr<PostgresJournal::Renewed> PostgresJournal::RenewRows(const DirectoryStore& self) {
  // What is another process's by its name is not prolonged.
  SqlStatements statements = {
      {"UPDATE corbslam.missions SET lease_until = clock_timestamp() + $2 * interval"
       " '1 millisecond' WHERE holder = $1 AND state = 0 AND NOT EXISTS"
       " (SELECT 1 FROM corbslam.stores WHERE stores.name = $3 AND stores.holder <> $1)"
       " RETURNING mission_id, wanted_store,"
       " (extract(epoch FROM clock_timestamp() - moved_at) * 1000)::bigint",
       {SqlValue::Number(holder_.id), holder_.LeaseMilliseconds(), SqlValue::Text(self.name)}}};
  if (!self.name.empty()) statements.push_back(SayAlive(self));
  ASSIGN_OR_RETURN(const std::vector<SqlResult> done, pool_->WriteAgain(statements));
  Renewed renewed;
  for (int i = 0; i < done[0].rows(); ++i) {
    const int64_t row = done[0].Number(i, 0);
    renewed.wanted[row] = done[0].Text(i, 1);
    if (!done[0].IsNull(i, 2)) renewed.since_moved[row] = absl::Milliseconds(done[0].Number(i, 2));
  }
  if (self.name.empty()) return renewed;
  renewed.is_replaced = done[1].rows() == 0;
  if (!renewed.is_replaced) renewed.duty = static_cast<StoreDuty>(done[1].Number(0, 0));
  return renewed;
}

void PostgresJournal::Renew() {
  const absl::Time began = SteadyNow();
  DirectoryStore self;
  std::vector<MissionPtr> to_release;
  {
    absl::MutexLock lock(&mutex_);
    // What another process may take now must not be prolonged.
    if (is_replaced_) return;
    self = self_;
    to_release.swap(to_release_);
  }
  std::vector<MissionPtr> held = All();
  std::erase_if(held, [](const MissionPtr& mission) { return !mission->IsHeld(); });
  for (const MissionPtr& mission : to_release) {
    if (mission->Release().ok()) continue;
    absl::MutexLock lock(&mutex_);
    to_release_.push_back(mission);
  }
  const absl::StatusOr<Renewed> renewed = RenewRows(self);
  LOG_IF(WARNING, !renewed.ok()) << "the missions' leases are not prolonged: " << renewed.status();
  {
    absl::MutexLock lock(&mutex_);
    counts_.reaches_database = renewed.ok();
    if (!renewed.ok()) {
      ++counts_.unreached;
      return;
    }
    counts_.held = renewed->wanted.size();
    is_replaced_ = renewed->is_replaced;
    duty_ = renewed->duty;
  }
  // What is lost is known before anybody may think that all else is held for longer.
  if (!FindLost(held, *renewed)) return;
  {
    absl::MutexLock lock(&mutex_);
    own_lease_.NoteProlonged(began);
  }
  FindMoves(held, self, *renewed);
  CountStandbys();
}

void PostgresJournal::FindMoves(const std::vector<MissionPtr>& held, const DirectoryStore& self,
                                const Renewed& renewed) {
  std::map<std::string, std::string> wanted;
  bool somebody_wants = renewed.duty == StoreDuty::kDrained;
  for (const MissionPtr& mission : held) {
    const auto row = renewed.wanted.find(mission->id());
    if (row == renewed.wanted.end()) continue;
    wanted[mission->name()] = row->second;
    somebody_wants |= !row->second.empty() && row->second != self.name;
  }
  const bool is_busy = options_.balance.above > 0 && self.load.has_value() &&
                       self.load->Pressure() > options_.balance.above;
  std::map<std::string, DirectoryStore> moves;
  std::string balancing;
  if (somebody_wants || is_busy) {
    const absl::StatusOr<std::vector<DirectoryStore>> stores = fleet_.ListStores();
    if (!stores.ok()) return;
    moves = PlanMoves(self.name, renewed.duty, wanted, *stores);
    if (moves.empty() && renewed.duty == StoreDuty::kTakesMissions) {
      moves = FindBalancingMove(held, self, renewed, *stores);
      if (!moves.empty()) balancing = moves.begin()->first;
    }
  }
  absl::MutexLock lock(&mutex_);
  moves_ = std::move(moves);
  balancing_ = std::move(balancing);
}

std::map<std::string, DirectoryStore> PostgresJournal::ListMoves() const {
  absl::MutexLock lock(&mutex_);
  return moves_;
}

absl::StatusOr<DirectoryStore> PostgresJournal::FindTaker(const DirectoryMission& mission) const {
  StoreDuty duty = StoreDuty::kTakesMissions;
  {
    absl::MutexLock lock(&mutex_);
    duty = duty_;
  }
  const bool is_elsewhere = duty != StoreDuty::kTakesMissions || !mission.wanted_address.empty();
  if (is_elsewhere) {
    ASSIGN_OR_RETURN(const std::vector<DirectoryStore> stores, ListStores());
    const DirectoryStore* taker = map_store::FindTaker(duty, mission.wanted, stores);
    if (taker != nullptr) return *taker;
  }
  return absl::NotFoundError("this store takes it itself");
}

bool PostgresJournal::FindLost(const std::vector<MissionPtr>& held, const Renewed& still) {
  bool all_known = true;
  for (const MissionPtr& mission : held) {
    if (still.wanted.count(mission->id()) > 0) continue;
    const absl::Status lost = mission->CheckStillHeld();
    all_known = all_known && !absl::IsUnavailable(lost);
    LOG_IF(WARNING, !lost.ok()) << "lease lost, or not known: " << lost;
  }
  return all_known;
}

void PostgresJournal::EndLeases() {
  const absl::Status ended =
      pool_
          ->WriteAgain({{"UPDATE corbslam.missions SET lease_until = NULL WHERE holder = $1",
                         {SqlValue::Number(holder_.id)}},
                        {"UPDATE corbslam.stores SET lease_until = NULL WHERE holder = $1",
                         {SqlValue::Number(holder_.id)}}})
          .status();
  LOG_IF(WARNING, !ended.ok()) << "the missions' leases end by themselves, after "
                               << absl::FormatDuration(options_.lease) << ": " << ended;
}

}  // namespace corbslam::map_store

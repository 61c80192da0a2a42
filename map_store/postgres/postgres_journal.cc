#include "map_store/postgres/postgres_journal.h"

#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/archive/batch_bytes.h"
#include "map_store/archive/record_archive.h"
#include "map_store/postgres/deleted_rows.h"
#include "map_store/postgres/postgres_mission.h"
#include "map_store/postgres/schema.h"
#include "map_store/postgres/sql_pool.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::Time SteadyNow() {
  return absl::UnixEpoch() + absl::FromChrono(std::chrono::steady_clock::now().time_since_epoch());
}

PostgresJournal::PostgresJournal(const PostgresJournalOptions& options,
                                 std::unique_ptr<SqlPool> pool)
    : options_(options),
      pool_(std::move(pool)),
      holder_{DrawRowId(), options.holder_name, options.lease},
      fleet_(pool_.get(), holder_.id),
      own_lease_(options.lease, SteadyNow()) {}

absl::StatusOr<std::unique_ptr<PostgresJournal>> PostgresJournal::Open(
    const PostgresJournalOptions& options) {
  ASSIGN_OR_RETURN(std::unique_ptr<SqlPool> pool, SqlPool::Make(options));
  LOG_IF(WARNING, !pool->warning().empty()) << pool->warning();
  RETURN_IF_ERROR(CheckSchema(*pool));
  std::unique_ptr<PostgresJournal> journal(new PostgresJournal(options, std::move(pool)));
  RETURN_IF_ERROR(GiveUpUnfinished(*journal->pool_));
  if (!journal->is_shared()) RETURN_IF_ERROR(journal->FindMissions());
  RETURN_IF_ERROR(journal->ReadLists());
  journal->tender_ = StartThread("journal writer", [self = journal.get()] { self->Tend(); });
  return journal;
}

PostgresJournal::~PostgresJournal() {
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
  }
  if (tender_.joinable()) tender_.join();
  for (const MissionPtr& mission : All()) {
    const absl::Status flushed = mission->FlushOlderThan(absl::InfiniteFuture());
    LOG_IF(WARNING, !flushed.ok()) << "what nobody was told of is lost: " << flushed;
  }
  if (is_shared()) EndLeases();
}

absl::Status PostgresJournal::FindMissions() {
  ASSIGN_OR_RETURN(const std::vector<SqlResult> read,
                   pool_->Read({{"SELECT mission_id, name, state, bytes FROM corbslam.missions"
                                 " WHERE name IS NOT NULL"}}));
  absl::MutexLock lock(&mutex_);
  for (int i = 0; i < read.front().rows(); ++i) {
    PostgresMission::Known known;
    known.id = read.front().Number(i, 0);
    known.is_made = true;
    known.is_aside = read.front().Number(i, 2) == static_cast<int64_t>(MissionStage::kAside);
    known.bytes = read.front().Bits(i, 3);
    const std::string name = read.front().Text(i, 1);
    missions_[name] =
        std::make_shared<PostgresMission>(name, options_, pool_.get(), holder_, known);
  }
  return absl::OkStatus();
}

absl::Status PostgresJournal::ReadLists() {
  for (const MissionList list : {MissionList::kDeleted, MissionList::kPromised}) {
    const SqlValue of = SqlValue::Number(static_cast<int64_t>(list));
    ASSIGN_OR_RETURN(const std::vector<SqlResult> read,
                     pool_->Read({{"SELECT name, uid FROM corbslam.mission_lists WHERE list = $1"
                                   " ORDER BY noted_at DESC, entry_id LIMIT $2",
                                   {of, SqlValue::Number(int64_t{kMaxListed})}}}));
    absl::MutexLock lock(&mutex_);
    std::vector<MissionIdentity>& missions = lists_[list];
    for (int i = read.front().rows(); i-- > 0;) {
      missions.push_back({read.front().Text(i, 0), read.front().Text(i, 1)});
    }
  }
  return absl::OkStatus();
}

PostgresJournal::MissionPtr PostgresJournal::FindKnown(absl::string_view name) const {
  absl::MutexLock lock(&mutex_);
  const auto it = missions_.find(std::string_view(name.data(), name.size()));
  return it == missions_.end() ? nullptr : it->second;
}

absl::StatusOr<PostgresJournal::MissionPtr> PostgresJournal::Find(absl::string_view name) const {
  if (MissionPtr known = FindKnown(name)) return known;
  if (is_shared()) return FindShared(name);
  return absl::NotFoundError(absl::StrCat(pool_->name(), " has no mission ", name));
}

absl::StatusOr<PostgresJournal::MissionPtr> PostgresJournal::FindHere(
    absl::string_view name) const {
  if (MissionPtr known = FindKnown(name)) return known;
  return absl::NotFoundError(absl::StrCat(pool_->name(), " has no mission ", name,
                                          is_shared() ? " that this process has" : ""));
}

PostgresJournal::MissionPtr PostgresJournal::FindOrBegin(absl::string_view name) {
  absl::MutexLock lock(&mutex_);
  MissionPtr& mission = missions_[std::string(name)];
  if (mission == nullptr) {
    PostgresMission::Known known;
    known.id = DrawRowId();
    mission =
        std::make_shared<PostgresMission>(std::string(name), options_, pool_.get(), holder_, known);
  }
  return mission;
}

std::vector<PostgresJournal::MissionPtr> PostgresJournal::All() const {
  std::vector<MissionPtr> missions;
  absl::MutexLock lock(&mutex_);
  for (const auto& [name, mission] : missions_) missions.push_back(mission);
  return missions;
}

void PostgresJournal::Tend() {
  const absl::Duration at_rest = is_shared() ? options_.lease / 3 : absl::InfiniteDuration();
  const auto has_work = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stops_ || has_waiting_ || has_deleted_;
  };
  while (true) {
    bool flushes = false;
    bool sweeps = false;
    {
      absl::MutexLock lock(&mutex_);
      if (mutex_.AwaitWithTimeout(absl::Condition(&has_work), at_rest)) {
        mutex_.AwaitWithTimeout(absl::Condition(&stops_), std::min(options_.flush_after, at_rest));
      }
      if (stops_) return;
      flushes = std::exchange(has_waiting_, false);
      sweeps = std::exchange(has_deleted_, false);
    }
    if (is_shared()) Renew();
    if (flushes) FlushWaiting();
    if (sweeps) Sweep();
  }
}

void PostgresJournal::FlushWaiting() {
  for (const MissionPtr& mission : All()) {
    const absl::Status flushed = mission->FlushOlderThan(absl::Now());
    LOG_IF(WARNING, !flushed.ok()) << "records wait: " << flushed;
  }
}

void PostgresJournal::Sweep() {
  const absl::Status swept = RemoveDeletedRows(*pool_, [this] {
    absl::MutexLock lock(&mutex_);
    return !stops_;
  });
  LOG_IF(WARNING, !swept.ok()) << "rows of deleted missions are left for now: " << swept;
}

void PostgresJournal::Prepare(BatchRecord& record) const { record.bytes = EncodeBatch(record); }

void PostgresJournal::Prepare(AdjustRecord& record) const {
  record.plan_bytes = std::make_shared<const PlanBytes>(EncodePlan(record.plan));
}

absl::StatusOr<Journal::Position> PostgresJournal::Append(absl::string_view mission,
                                                          const JournalRecord& record) {
  const MissionPtr found = FindOrBegin(mission);
  const absl::StatusOr<Position> appended = found->Append(BytesOf(record), RemovedBy(record));
  absl::MutexLock lock(&mutex_);
  has_waiting_ = true;
  return appended;
}

absl::Status PostgresJournal::Sync(absl::string_view mission, Position position) {
  const MissionPtr found = FindKnown(mission);
  // A mission without any record, or one that was deleted, has nothing to sync.
  return found != nullptr ? found->Sync(position) : absl::OkStatus();
}

bool PostgresJournal::WantsSnapshot(absl::string_view mission) const {
  const MissionPtr found = FindKnown(mission);
  return found != nullptr && found->WantsSnapshot();
}

absl::Status PostgresJournal::WriteSnapshot(absl::string_view mission,
                                            const JournalSnapshot& snapshot) {
  ASSIGN_OR_RETURN(const MissionPtr found, FindHere(mission));
  return found->WriteSnapshot(snapshot);
}

absl::Status PostgresJournal::CreateMission(absl::string_view mission, const MissionState& state) {
  const absl::Status made = FindOrBegin(mission)->Create(state);
  if (made.ok()) return made;
  absl::MutexLock lock(&mutex_);
  missions_.erase(std::string(mission));
  has_deleted_ = true;
  return made;
}

absl::StatusOr<std::vector<std::string>> PostgresJournal::ListMissions() const {
  std::vector<std::string> names;
  absl::MutexLock lock(&mutex_);
  for (const auto& [name, mission] : missions_) names.push_back(name);
  return names;
}

absl::StatusOr<Journal::Position> PostgresJournal::Recover(absl::string_view mission,
                                                           const Replay& replay) const {
  // A mission is taken to be read as a whole, and not by who looks at its past.
  const absl::StatusOr<MissionPtr> found =
      is_shared() && !replay.with_features ? FindHere(mission) : Find(mission);
  if (absl::IsNotFound(found.status())) return 0;
  RETURN_IF_ERROR(found.status());
  return (*found)->Recover(replay);
}

absl::Status PostgresJournal::DeleteMission(absl::string_view mission) {
  const absl::StatusOr<MissionPtr> found = Find(mission);
  if (!found.ok()) return absl::OkStatus();
  RETURN_IF_ERROR((*found)->Delete());
  absl::MutexLock lock(&mutex_);
  missions_.erase(std::string(mission));
  has_deleted_ = true;
  return absl::OkStatus();
}

absl::Status PostgresJournal::NoteInList(MissionList list, const MissionIdentity& mission) {
  RETURN_IF_ERROR(
      pool_
          ->WriteAgain(
              {{"INSERT INTO corbslam.mission_lists (list, noted_at, entry_id, name, uid)"
                " VALUES ($1, clock_timestamp(), $2, $3, $4)",
                {SqlValue::Number(static_cast<int64_t>(list)), SqlValue::Number(DrawRowId()),
                 SqlValue::Text(mission.name), SqlValue::Text(mission.uid)}}})
          .status());
  absl::MutexLock lock(&mutex_);
  std::vector<MissionIdentity>& missions = lists_[list];
  missions.push_back(mission);
  if (missions.size() > kMaxListed) missions.erase(missions.begin());
  return absl::OkStatus();
}

std::vector<MissionIdentity> PostgresJournal::ReadList(MissionList list) const {
  absl::MutexLock lock(&mutex_);
  const auto it = lists_.find(list);
  return it == lists_.end() ? std::vector<MissionIdentity>() : it->second;
}

void PostgresJournal::TidyUp(absl::string_view mission) {
  const absl::StatusOr<MissionPtr> found = FindHere(mission);
  if (found.ok()) (*found)->TidyUp();
}

absl::Status PostgresJournal::PutAside(absl::string_view mission, absl::string_view summary) {
  ASSIGN_OR_RETURN(const MissionPtr found, FindHere(mission));
  const absl::Status aside = found->PutAside(summary);
  // Whoever takes it next, perhaps another process, looks for it again.
  if (is_shared()) LetGo(mission);
  return aside;
}

absl::StatusOr<std::string> PostgresJournal::ReadSummary(absl::string_view mission) const {
  ASSIGN_OR_RETURN(const MissionPtr found, Find(mission));
  return found->ReadSummary();
}

absl::Status PostgresJournal::PutPicture(absl::string_view mission, const KeyframePicture& picture,
                                         uint64_t max_bytes) {
  // A picture makes no mission: it may have been deleted just now.
  ASSIGN_OR_RETURN(const MissionPtr found, FindHere(mission));
  return found->PutPicture(picture, max_bytes);
}

absl::StatusOr<KeyframePicture> PostgresJournal::ReadPicture(absl::string_view mission,
                                                             KeyframeId keyframe) const {
  ASSIGN_OR_RETURN(const MissionPtr found, FindHere(mission));
  return found->ReadPicture(keyframe);
}

absl::Status PostgresJournal::ForEachPicture(
    absl::string_view mission,
    const std::function<absl::Status(const KeyframePicture& picture)>& visit) const {
  ASSIGN_OR_RETURN(const MissionPtr found, FindHere(mission));
  return found->ForEachPicture(visit);
}

absl::Status PostgresJournal::CheckWritable() {
  RETURN_IF_ERROR(pool_->CheckWrites());
  for (const MissionPtr& mission : All()) RETURN_IF_ERROR(mission->CheckWritable());
  return absl::OkStatus();
}

absl::Status PostgresJournal::Damage(absl::string_view mission) const {
  const MissionPtr found = FindKnown(mission);
  return found != nullptr ? found->Damage() : absl::OkStatus();
}

uint64_t PostgresJournal::DiskBytes(absl::string_view mission) const {
  const MissionPtr found = FindKnown(mission);
  return found != nullptr ? found->DiskBytes() : 0;
}

}  // namespace corbslam::map_store

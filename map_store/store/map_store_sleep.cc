// Implements the part of MapStore that knows of missions on the disk alone.
#include <glog/logging.h>

#include <limits>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/mission/mission_load.h"
#include "map_store/process/fusion_executor.h"
#include "map_store/process/memory_budget.h"
#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/process/mission_evictor.h"
#include "map_store/process/mission_loader.h"
#include "map_store/records/mission_leases.h"
#include "map_store/store/map_store.h"
#include "map_store/view/damage_text.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Missions that are read at one time.
constexpr int kLoaderThreads = 2;

}  // namespace

MissionInfo MapStore::Describe(const KnownMission& known) const {
  if (!known.damage.ok()) return InfoOfUnreadable(known.name, known.damage);
  MissionInfo info;
  if (known.mission != nullptr) {
    info = known.mission->Info();
    info.disk_bytes = journal_->DiskBytes(info.name);
  } else {
    info = known.evicted->summary.info;
    info.asleep = true;
  }
  if (info.profile.last_used_ns == 0) {
    info.profile.last_used_ns = absl::ToUnixNanos(known.last_used);
  }
  info.has_worker = has_worker();
  info.worker_outage = worker_outage();
  info.damage = SayDamage(info.name, journal_->Damage(info.name));
  return info;
}

std::vector<MissionLoad> MapStore::ListLoads() const {
  std::vector<MissionLoad> loads;
  for (const KnownMission& known : directory_->List("", std::numeric_limits<size_t>::max())) {
    if (known.mission != nullptr) loads.push_back(known.mission->Load());
    if (known.evicted != nullptr) loads.push_back(known.evicted->summary.load);
  }
  return loads;
}

absl::StatusOr<std::shared_ptr<Mission>> MapStore::LoadEvicted(const std::string& name,
                                                               const EvictedMission& evicted) {
  const absl::Time begin = absl::Now();
  // This one is counted already.
  MakeRoomForMissions(0);
  if (const size_t in_memory = directory_->Count().in_memory; in_memory > options_.max_missions) {
    return absl::ResourceExhaustedError(
        absl::StrCat("mission ", name, " is asleep, and ", in_memory - 1,
                     " missions are in memory and used; that is the limit (--max-missions)"));
  }
  RETURN_IF_ERROR(
      memory_->Check(absl::StrCat("mission ", name), evicted.summary.info.memory_bytes));
  std::shared_ptr<Mission> mission = MakeMission(name);
  if (const absl::Status recovered = mission->Recover(); !recovered.ok()) {
    const bool is_elsewhere = FindElsewhere(recovered).has_value();
    LOG_IF(ERROR, !is_elsewhere) << "mission " << name << " can't be read: " << recovered;
    if (leases_ != nullptr && !absl::IsDataLoss(recovered)) leases_->LetGo(name);
    return recovered;
  }
  mission->EnsureUid();
  mission->events().GoOnFrom(evicted.events);
  if (evicted.summary.retired) mission->retiring().NoteAllDone();
  ++woken_;
  waking_ns_ += absl::ToInt64Nanoseconds(absl::Now() - begin);
  Wake();
  return mission;
}

bool MapStore::AddEvicted(const std::string& name) {
  if (!sleeps_by_itself()) return false;
  const absl::StatusOr<std::string> bytes = journal_->ReadSummary(name);
  if (absl::IsNotFound(bytes.status())) return false;
  const absl::StatusOr<MissionSummary> summary =
      bytes.ok() ? DecodeSummary(*bytes) : bytes.status();
  if (!summary.ok() || summary->info.name != name) {
    LOG(WARNING) << "mission " << name
                 << " is read, as it has no good summary: " << summary.status();
    return false;
  }
  if (summary->work_left && has_worker()) return false;
  EvictedMission evicted{*summary, {}};
  evicted.NoteEvicted(journal_->DiskBytes(name));
  directory_->AddEvicted(name, std::move(evicted));
  return true;
}

void MapStore::MakeRoomForMissions(size_t coming) {
  if (!sleeps_by_itself() || directory_->Count().in_memory + coming <= options_.max_missions) {
    return;
  }
  evictor_->MakeRoom(/*in_haste=*/true);
}

void MapStore::StartEviction() {
  const absl::Duration after =
      options_.sleep_after_s > 0 ? absl::Seconds(options_.sleep_after_s) : absl::InfiniteDuration();
  evictor_ = std::make_unique<MissionEvictor>(*directory_, *journal_, *memory_, clock_, after);
  loader_ = std::make_unique<MissionLoader>(
      *directory_, [this](const std::string& mission) { return AwaitMission(mission); });
  if (!journal_->KeepsRecords()) return;
  if (!options_.deterministic) loader_->Start(kLoaderThreads);
  if (!sleeps_by_itself()) return;
  memory_->SetRoomMaker([this] { return evictor_->MakeRoom(/*in_haste=*/true); });
  if (!options_.deterministic) evictor_->Start();
}

void MapStore::EndEviction() {
  loader_->Stop();
  evictor_->Stop();
  {
    std::map<uint64_t, Session> left;
    absl::MutexLock lock(&mutex_);
    left.swap(sessions_);
  }
  if (sleeps_by_itself()) evictor_->EvictAll(absl::Seconds(options_.end_s));
}

absl::Status MapStore::SleepMission(absl::string_view mission) {
  if (leases_ != nullptr && absl::IsNotFound(directory_->Peek(mission).status())) {
    ASSIGN_OR_RETURN(const DirectoryMission listed, leases_->Look(mission));
    if (listed.is_asleep) return absl::OkStatus();
    RETURN_IF_ERROR(FindMission(mission).status());
  }
  return evictor_->Evict(mission);
}

size_t MapStore::SleepUnused() { return evictor_->EvictUnused(); }

absl::Status MapStore::WhenAwake(
    const std::string& mission,
    std::function<void(const absl::StatusOr<std::shared_ptr<const void>>& awake)> then) {
  return loader_->WhenLoaded(mission, std::move(then));
}

MapStore::Sleep MapStore::sleep() const {
  return {.asleep = directory_->Count().asleep,
          .fallen_asleep = evictor_->evictions(),
          .woken = woken_,
          .waking_s = absl::ToDoubleSeconds(absl::Nanoseconds(waking_ns_.load()))};
}

}  // namespace corbslam::map_store

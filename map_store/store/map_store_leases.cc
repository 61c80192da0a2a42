// Implements the part of MapStore that shares the missions of one journal with other stores: which
// of them it takes, and what becomes of those that it has lost.
#include <glog/logging.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/fleet/load_meter.h"
#include "map_store/process/departed_missions.h"
#include "map_store/process/memory_budget.h"
#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/process/process_load.h"
#include "map_store/records/mission_leases.h"
#include "map_store/store/map_store.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status ElsewhereError(const DirectoryMission& listed) {
  const std::string where = listed.address.empty() ? "another map store" : listed.address;
  return WithElsewhere(
      absl::UnavailableError(absl::StrCat(
          "mission ", listed.name, " is at ", where, " (", listed.holder, "), whose lease ends in ",
          absl::FormatDuration(listed.lease_left), " unless it prolongs it")),
      listed.address);
}

// Returns what robots of a mission are told that this store has no more.
absl::Status LostError(const std::string& name, const absl::Status& why) {
  const auto elsewhere = FindElsewhere(why);
  return WithElsewhere(absl::UnavailableError(absl::StrCat(
                           "mission ", name, " is not this store's any more: ", why.message())),
                       elsewhere.has_value() ? elsewhere->address : "");
}

absl::Status IsForAnother(absl::string_view name, const std::string& address,
                          absl::string_view why) {
  return WithElsewhere(
      absl::UnavailableError(absl::StrCat("mission ", name, " is to be at ", address, ": ", why)),
      address);
}

// Returns who is to have a mission, that nobody has, instead of this store.
absl::Status CheckMayTake(const DirectoryMission& listed, const MissionLeases& leases) {
  const absl::StatusOr<DirectoryStore> taker = leases.FindTaker(listed);
  if (absl::IsNotFound(taker.status())) return absl::OkStatus();
  RETURN_IF_ERROR(taker.status());
  return IsForAnother(
      listed.name, taker->address,
      taker->name == listed.wanted ? "it was moved there" : "this store takes no more missions");
}

EvictedMission EvictedOf(const DirectoryMission& listed) {
  EvictedMission evicted;
  if (auto summary = DecodeSummary(listed.summary); listed.is_asleep && summary.ok()) {
    evicted.summary = *std::move(summary);
  }
  evicted.summary.info.name = evicted.summary.load.mission = listed.name;
  evicted.NoteEvicted(listed.bytes);
  return evicted;
}

// Gives a mission to another store, whose robots are told of it once they can go there.
absl::Status GiveAway(const std::string& name, const DirectoryStore& store, MissionLeases& leases,
                      MissionDirectory& directory) {
  const std::shared_ptr<Mission> mission = directory.UseIfLoaded(name);
  // It falls asleep, or wakes, or is gone.
  if (mission == nullptr) return absl::OkStatus();
  LOG(INFO) << "mission " << name << " goes to store " << store.name;
  const absl::Time begin = absl::Now();
  mission->Close(IsForAnother(name, store.address, "it moves there"));
  const absl::Status given = leases.GiveTo(name, store.name);
  // What could not be given away is given back when its lease is over, and read again.
  if (!given.ok()) leases.LetGo(name);
  directory.Remove(name, mission.get());
  mission->CallListeners();
  LOG(INFO) << "mission " << name << " went after "
            << absl::FormatDuration(absl::Trunc(absl::Now() - begin, absl::Milliseconds(1)));
  return given;
}

}  // namespace

absl::Status MapStore::TakeIn(absl::string_view name) const {
  RETURN_IF_ERROR(leases_->CheckReached());
  ASSIGN_OR_RETURN(const DirectoryMission listed, leases_->Look(name));
  if (listed.IsHeldByAnother()) return ElsewhereError(listed);
  if (!listed.is_own) RETURN_IF_ERROR(CheckMayTake(listed, *leases_));
  directory_->AddEvicted(listed.name, EvictedOf(listed));
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<Mission>> MapStore::AwaitMission(absl::string_view name) const {
  absl::StatusOr<std::shared_ptr<Mission>> mission = directory_->Use(name);
  if (leases_ != nullptr && absl::IsNotFound(mission.status())) {
    RETURN_IF_ERROR(TakeIn(name));
    mission = directory_->Use(name);
  }
  if (mission.ok()) (*mission)->profile().NoteUse();
  return mission;
}

absl::Status MapStore::ReadDeparted(const std::string& name) {
  ASSIGN_OR_RETURN(const std::vector<MissionIdentity> deleted,
                   journal_->ReadListOf(MissionList::kDeleted, name));
  for (const MissionIdentity& mission : deleted) {
    if (!departed_->Has(mission.name, mission.uid)) departed_->Note(mission, {});
  }
  return absl::OkStatus();
}

absl::Status MapStore::MakeShared(const SessionRequest& request) {
  absl::MutexLock making(&making_mutex_);
  const absl::Status found = FindMission(request.mission).status();
  if (!absl::IsNotFound(found)) return found;
  RETURN_IF_ERROR(ReadDeparted(request.mission));
  RETURN_IF_ERROR(CheckNotDeparted(request));
  const absl::Status made = WriteShared(request);
  // Another store may have made it at the same moment.
  const bool is_there = absl::IsFailedPrecondition(made) || absl::IsAlreadyExists(made);
  return is_there ? TakeIn(request.mission) : made;
}

absl::Status MapStore::WriteShared(const SessionRequest& request) {
  DirectoryMission made_here;
  made_here.name = request.mission;
  RETURN_IF_ERROR(CheckMayTake(made_here, *leases_));
  RETURN_IF_ERROR(ReserveName(request.mission));
  std::shared_ptr<Mission> mission = BeginMission(request.mission, request.mission_uid);
  // A robot is told the uid, and any store is to know it.
  const absl::Status made = mission->WriteUid();
  if (!made.ok()) {
    mission.reset();
    leases_->LetGo(request.mission);
  }
  directory_->EndMaking(request.mission, std::move(mission));
  return made;
}

void MapStore::KeepLeases() {
  // Asked first: once the journal is reached again, it knows what was lost meanwhile.
  const absl::Status reached = leases_->CheckReached();
  const std::map<std::string, absl::Status> lost = leases_->TakeLost();
  for (const auto& [name, why] : lost) {
    const auto mission = directory_->UseIfLoaded(name);
    if (mission != nullptr) mission->RefuseRobots(LostError(name, why));
  }
  for (const auto& [name, why] : lost) LoseMission(name, why);
  for (const auto& [name, store] : leases_->ListMoves()) {
    const absl::Status given = GiveAway(name, store, *leases_, *directory_);
    LOG_IF(WARNING, !given.ok()) << "mission " << name << " does not go to " << store.name << ": "
                                 << given;
  }
  if (reached.ok() != refuses_) return;
  refuses_ = !reached.ok();
  LOG(WARNING) << (refuses_ ? "robots are refused: " : "robots are taken in again")
               << (refuses_ ? reached.ToString() : "");
  for (const std::weak_ptr<Mission>& loaded : directory_->ListLoaded()) {
    if (const std::shared_ptr<Mission> mission = loaded.lock()) mission->RefuseRobots(reached);
  }
}

void MapStore::TellLoad() {
  const absl::Time now = clock_();
  // The directory hears of it as leases are prolonged.
  if (now - load_told_at_ < std::max(leases_->lease() / 3, absl::Seconds(1))) return;
  load_told_at_ = now;
  LoadMeter::Reading reading;
  reading.time = now;
  reading.processor_s = ProcessorSeconds();
  reading.processors = UsableProcessors();
  reading.resident_bytes = ResidentBytes();
  reading.budget_bytes = memory_->limit_bytes();
  uint64_t waiting = 0;
  for (const MissionLoad& load : ListLoads()) {
    reading.missions[load.mission] = {load.keyframes, load.memory_bytes};
    waiting += load.waiting.verify + load.waiting.fuse + load.waiting.adjust;
  }
  std::optional<WeighedStore> weighed = load_meter_->Note(reading);
  if (!weighed.has_value()) return;
  weighed->waiting_requests = waiting;
  leases_->NoteLoad(*weighed);
}

void MapStore::LoseMission(const std::string& name, const absl::Status& why) {
  LOG(WARNING) << "mission " << name << " is lost to another store: " << why;
  const absl::StatusOr<KnownMission> known = directory_->Peek(name);
  if (known.ok() && known->mission != nullptr) known->mission->Lose(LostError(name, why));
  leases_->LetGo(name);
  if (!known.ok()) return;
  directory_->Remove(name, known->mission.get());
  // Watchers find out where it is.
  if (known->mission != nullptr) known->mission->CallListeners();
}

MissionInfo MapStore::Describe(const DirectoryMission& listed) const {
  if (!listed.is_asleep) {
    const absl::StatusOr<KnownMission> known = directory_->Peek(listed.name);
    if (known.ok() && (known->mission != nullptr || !known->damage.ok())) return Describe(*known);
  }
  MissionInfo info = EvictedOf(listed).summary.info;
  info.asleep = listed.is_asleep;
  info.has_worker = has_worker();
  info.worker_outage = worker_outage();
  return info;
}

absl::StatusOr<MissionInfo> MapStore::GetShared(absl::string_view name) const {
  ASSIGN_OR_RETURN(const DirectoryMission listed, leases_->Look(name));
  if (listed.is_asleep) return Describe(listed);
  RETURN_IF_ERROR(FindMission(name).status());
  ASSIGN_OR_RETURN(const KnownMission known, directory_->Peek(name));
  return Describe(known);
}

absl::StatusOr<std::vector<MissionInfo>> MapStore::ListShared(absl::string_view after,
                                                              size_t count) const {
  ASSIGN_OR_RETURN(const std::vector<DirectoryMission> listed, leases_->List(after, count));
  std::vector<MissionInfo> missions;
  for (const DirectoryMission& mission : listed) missions.push_back(Describe(mission));
  return missions;
}

}  // namespace corbslam::map_store

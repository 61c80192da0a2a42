#include "map_store/store/map_store.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/fleet/load_meter.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/process/departed_missions.h"
#include "map_store/process/fusion_executor.h"
#include "map_store/process/memory_budget.h"
#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/process/mission_evictor.h"
#include "map_store/process/mission_loader.h"
#include "map_store/process/mission_tender.h"
#include "map_store/process/promised_uids.h"
#include "map_store/process/snapshot_keeper.h"
#include "map_store/records/mission_leases.h"
#include "map_store/records/restored_state.h"
#include "map_store/state/mission_uid.h"
#include "map_store/view/damage_text.h"
#include "slam/exchange/session_end.h"
#include "slam/util/memory_returner.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Of the lease keeper.
constexpr absl::Duration kBetweenLooks = absl::Milliseconds(250);

absl::Status CheckRoom(const MissionDirectory::Counts& counts, const MapStoreOptions& options) {
  if (counts.asleep >= options.max_missions_asleep) {
    return absl::ResourceExhaustedError(
        absl::StrCat(counts.asleep, " missions that are asleep; that is the limit"));
  }
  if (counts.in_memory < options.max_missions) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat(counts.in_memory, " missions; that is the limit"));
}

}  // namespace

MapStore::MapStore(const MapStoreOptions& options, std::shared_ptr<const Vocabulary> vocabulary,
                   std::unique_ptr<Journal> journal, FusionWorker* worker, Clock clock)
    : options_(options),
      vocabulary_(std::move(vocabulary)),
      journal_(std::move(journal)),
      leases_(journal_->leases()),
      clock_(std::move(clock)),
      memory_(std::make_unique<MemoryBudget>(options.memory_budget_bytes, &ResidentBytes, clock_,
                                             &UsedBytes)),
      memory_returner_(std::make_unique<MemoryReturner>()),
      executor_(std::make_unique<FusionExecutor>(worker, absl::Milliseconds(options.retry_ms),
                                                 clock_, [this] { memory_returner_->Wake(); })),
      snapshots_(std::make_unique<SnapshotKeeper>(clock_)),
      tender_(std::make_unique<MissionTender>([this] { TendMissions(); })),
      lease_keeper_(std::make_unique<MissionTender>(
          [this] {
            KeepLeases();
            TellLoad();
          },
          kBetweenLooks)),
      departed_(std::make_unique<DepartedMissions>()),
      promised_uids_(std::make_unique<PromisedUids>(*journal_)),
      load_meter_(std::make_unique<LoadMeter>()) {
  directory_ = std::make_unique<MissionDirectory>(
      clock_,
      [this](const std::string& name, const EvictedMission& evicted) {
        return LoadEvicted(name, evicted);
      },
      leases_ == nullptr ? MissionDirectory::Asleep::kRemembered
                         : MissionDirectory::Asleep::kForgotten);
  StartEviction();
  memory_returner_->Start();
  if (options_.deterministic) return;
  const auto list_missions = [this] { return directory_->ListLoaded(); };
  executor_->Start(list_missions, options_.fusion_threads);
  snapshots_->Start(list_missions, [this] { memory_returner_->Wake(); });
  tender_->Start();
  if (leases_ != nullptr) lease_keeper_->Start();
}

MapStore::~MapStore() {
  tender_->Stop();
  lease_keeper_->Stop();
  snapshots_->Stop();
  executor_->Stop();
  EndEviction();
}

void MapStore::Wake() {
  executor_->Wake();
  snapshots_->Wake();
}

absl::StatusOr<std::shared_ptr<Mission>> MapStore::FindMission(absl::string_view name) const {
  if (!options_.wake_in_background) return AwaitMission(name);
  absl::StatusOr<std::shared_ptr<Mission>> mission = directory_->UseLoaded(name);
  if (leases_ != nullptr && absl::IsNotFound(mission.status())) {
    RETURN_IF_ERROR(TakeIn(name));
    mission = directory_->UseLoaded(name);
  }
  if (mission.ok()) (*mission)->profile().NoteUse();
  return mission;
}

absl::Status MapStore::Recover() {
  for (MissionIdentity& deleted : journal_->ReadList(MissionList::kDeleted)) {
    departed_->Note(std::move(deleted), {});
  }
  promised_uids_->Recover();
  if (leases_ != nullptr) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<std::string> names, journal_->ListMissions());
  for (const std::string& name : names) {
    if (AddEvicted(name)) continue;
    std::shared_ptr<Mission> mission = MakeMission(name);
    const absl::Status recovered = mission->Recover();
    LOG_IF(ERROR, !recovered.ok()) << SayDamage(name, recovered);
    if (!recovered.ok() && !absl::IsDataLoss(recovered)) return recovered;
    if (recovered.ok()) {
      mission->EnsureUid();
      directory_->Add(name, std::move(mission));
    } else {
      directory_->AddUnreadable(name, recovered);
    }
    while (sleeps_by_itself() && memory_->IsShort() && evictor_->MakeRoom(/*in_haste=*/true)) {
      ReturnFreeMemory();
    }
  }
  Wake();
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> MapStore::EnterMission(const SessionRequest& request) {
  const std::string& name = request.mission;
  if (const absl::Status damage = journal_->Damage(name); !damage.ok()) {
    return absl::DataLossError(SayDamage(name, damage));
  }
  const auto make =
      [&](const MissionDirectory::Counts& counts) -> absl::StatusOr<std::shared_ptr<Mission>> {
    RETURN_IF_ERROR(CheckRoom(counts, options_));
    return BeginMission(name, request.mission_uid);
  };
  absl::StatusOr<std::shared_ptr<Mission>> found = FindMission(name);
  if (leases_ != nullptr && absl::IsNotFound(found.status())) {
    RETURN_IF_ERROR(MakeShared(request));
    found = FindMission(name);
  } else if (absl::IsNotFound(found.status())) {
    MakeRoomForMissions(1);
    found = directory_->UseOrMake(name, make);
  }
  ASSIGN_OR_RETURN(std::shared_ptr<Mission> mission, std::move(found));
  uint64_t session_id = 0;
  {
    absl::MutexLock lock(&mutex_);
    mission->profile().NoteUse();
    session_id = next_session_++;
    sessions_[session_id] = {request.agent, mission};
  }
  // Whoever closes the mission after this sees the session.
  absl::Status entered = directory_->CheckEntered(name, *mission);
  // Another one may have got the name a moment ago.
  if (!request.mission_uid.empty() && mission->uid() != request.mission_uid) {
    entered = MissionDeletedError(name);
  }
  if (entered.ok()) return session_id;
  LeaveMission(session_id);
  return entered;
}

void MapStore::LeaveMission(uint64_t session_id) {
  Session left;
  absl::MutexLock lock(&mutex_);
  const auto it = sessions_.find(session_id);
  if (it == sessions_.end()) return;
  left = std::move(it->second);
  left.mission->profile().NoteUse();
  sessions_.erase(it);
}

std::shared_ptr<Mission> MapStore::BeginMission(const std::string& name, const std::string& uid) {
  std::shared_ptr<Mission> mission = MakeMission(name);
  mission->BeginAs(uid.empty() ? UidToBegin(name) : uid);
  return mission;
}

std::shared_ptr<Mission> MapStore::MakeMission(const std::string& name) {
  MissionEnvironment environment;
  environment.options = &options_;
  environment.vocabulary = vocabulary_.get();
  environment.journal = journal_.get();
  environment.clock = clock_;
  environment.wake_fusion = [this] { Wake(); };
  environment.has_worker = executor_->has_worker();
  environment.note_uid = uid_listener_;
  environment.promise_uid = [this](const MissionIdentity& mission) {
    return promised_uids_->Promise(mission);
  };
  environment.memory = memory_.get();
  // What it took is free only when the last one who has it lets it go.
  return {new Mission(name, std::move(environment)), [this](Mission* mission) {
            const bool is_worth_while = !mission->IsVacant();
            delete mission;
            if (is_worth_while) memory_returner_->Wake();
          }};
}

absl::StatusOr<MapStore::Session> MapStore::FindSession(uint64_t session_id) const {
  absl::MutexLock lock(&mutex_);
  const auto it = sessions_.find(session_id);
  if (it != sessions_.end()) return it->second;
  return absl::NotFoundError(absl::StrCat("there is no session ", session_id));
}

absl::StatusOr<MapStore::OpenedSession> MapStore::OpenSession(const SessionRequest& request) {
  RETURN_IF_ERROR(map_store::ValidateName("mission", request.mission));
  RETURN_IF_ERROR(map_store::ValidateName("agent", request.agent));
  RETURN_IF_ERROR(CheckNotDeparted(request));
  absl::StatusOr<OpenedSession> opened = OpenSessionOf(request);
  // A deletion that came between has the last word.
  if (!opened.ok()) RETURN_IF_ERROR(CheckNotDeparted(request));
  return opened;
}

absl::StatusOr<MapStore::OpenedSession> MapStore::OpenSessionOf(const SessionRequest& request) {
  if (request.localise_only) RETURN_IF_ERROR(FindMission(request.mission).status());
  ASSIGN_OR_RETURN(const uint64_t session_id, EnterMission(request));
  ASSIGN_OR_RETURN(const Session session, FindSession(session_id));
  absl::StatusOr<SessionGrant> grant = session.mission->sessions().Open(session_id, request);
  if (!grant.ok()) {
    LeaveMission(session_id);
    return grant.status();
  }
  // What the robot is told of its acknowledgements was so if nobody else can have had the mission
  // by now: this process may have been stopped for a minute, and be as sure as it was before.
  const absl::Status still = leases_ == nullptr ? absl::OkStatus() : leases_->CheckReached();
  if (!still.ok()) {
    CloseSession(session_id);
    return still;
  }
  return OpenedSession{session_id, *std::move(grant)};
}

absl::StatusOr<Acknowledgement> MapStore::Apply(uint64_t session_id, const MapUpdateBatch& batch,
                                                const BatchTransfer* measured) {
  ASSIGN_OR_RETURN(const Session session, FindSession(session_id));
  session.mission->profile().NoteUse();
  return session.mission->batches().Apply(session_id, session.agent, batch, measured);
}

absl::StatusOr<std::optional<LocalisedKept>> MapStore::NoteLocalised(
    uint64_t session_id, const LocalisedFrames& localised) {
  ASSIGN_OR_RETURN(const Session session, FindSession(session_id));
  session.mission->profile().NoteUse();
  return session.mission->localised().Note(session_id, session.agent, localised);
}

absl::Status MapStore::KeepPicture(uint64_t session_id, const KeyframePicture& picture) {
  ASSIGN_OR_RETURN(const Session session, FindSession(session_id));
  return session.mission->pictures().Keep(session_id, session.agent, picture);
}

absl::Status MapStore::NoteReport(uint64_t session_id, const AgentReport& report) {
  ASSIGN_OR_RETURN(const Session session, FindSession(session_id));
  RETURN_IF_ERROR(session.mission->sessions().NoteReport(session_id, session.agent, report));
  session.mission->fusion().KeepApart(session.agent, report.contradictions);
  return absl::OkStatus();
}

void MapStore::CloseSession(uint64_t session_id, bool on_purpose) {
  const absl::StatusOr<Session> session = FindSession(session_id);
  if (!session.ok()) return;
  session->mission->sessions().Close(session_id, session->agent, on_purpose);
  LeaveMission(session_id);
}

absl::StatusOr<std::optional<SharedUpdate>> MapStore::NextShared(uint64_t session_id,
                                                                 size_t byte_budget) {
  ASSIGN_OR_RETURN(const Session session, FindSession(session_id));
  return session.mission->sessions().NextShared(session_id, session.agent, byte_budget);
}

absl::Status MapStore::AskForExactPlaces(absl::string_view mission_name, const std::string& agent) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->sessions().AskForExactPlaces(agent);
}

bool MapStore::TakeExactPlacesWanted(uint64_t session_id) {
  const absl::StatusOr<Session> session = FindSession(session_id);
  return session.ok() && session->mission->sessions().TakeExactPlacesWanted(session->agent);
}

void MapStore::SetSharedListener(uint64_t session_id, std::function<void()> listener) {
  const absl::StatusOr<Session> session = FindSession(session_id);
  if (session.ok()) session->mission->listeners().SetOfSession(session_id, std::move(listener));
}

absl::Status MapStore::RunFusionUntilIdle(absl::string_view mission_name) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  mission->snapshots().Keep([] { return true; }).status().IgnoreError();
  executor_->RunUntilIdle(*mission);
  return absl::OkStatus();
}

absl::Status MapStore::RederiveGlobalLayer(absl::string_view mission_name) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->fusion().Rederive();
}

absl::StatusOr<std::vector<uint64_t>> MapStore::RetractOverlap(absl::string_view mission_name,
                                                               uint64_t overlap, bool keep_apart) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->fusion().RetractOverlap(overlap, keep_apart);
}

absl::StatusOr<ForgottenLocalMaps> MapStore::ForgetLocalMaps(absl::string_view mission_name,
                                                             const ForgetRequest& request) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  ASSIGN_OR_RETURN(ForgottenLocalMaps forgotten, mission->joining().Forget(request));
  // A snapshot in the place of all records gives the disk back.
  if (!request.dry_run && !forgotten.local_maps.empty()) {
    mission->snapshots().KeepAll([] { return true; }).status().IgnoreError();
  }
  return forgotten;
}

absl::StatusOr<bool> MapStore::IsFusionIdle(absl::string_view mission_name) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->fusion().IsIdle() && !mission->retiring().IsDue() && !mission->joining().IsDue();
}

absl::Status MapStore::WaitUntilFusionIdle(absl::string_view mission_name,
                                           absl::Duration timeout) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  if (mission->fusion().WaitUntilIdle(absl::Now() + timeout)) return absl::OkStatus();
  return absl::DeadlineExceededError(absl::StrCat(
      "fusion of mission ", mission_name, " is busy after ", absl::FormatDuration(timeout)));
}

absl::Status MapStore::DeleteMission(absl::string_view mission_name, absl::string_view uid) {
  std::shared_ptr<Mission> taken;
  if (leases_ != nullptr) {
    absl::StatusOr<std::shared_ptr<Mission>> found = FindMission(mission_name);
    if (!absl::IsDataLoss(found.status())) RETURN_IF_ERROR(found.status());
    if (found.ok()) taken = *std::move(found);
  }
  ASSIGN_OR_RETURN(const MissionDirectory::Life life, directory_->FindLife(mission_name));
  RETURN_IF_ERROR(CheckUid(mission_name, uid));
  // A caller that waited for another one's deletion must not delete the mission that has got the
  // name since.
  absl::MutexLock deleting(&deletion_mutex_);
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission,
                   directory_->BeginDeletion(mission_name, life));
  // From here on nothing is appended to the journal, so that what is deleted stays deleted.
  if (mission != nullptr) mission->Delete();
  return EndLife(mission_name, mission);
}

absl::Status MapStore::EndLife(absl::string_view name, const std::shared_ptr<Mission>& mission) {
  NoteDeparture(name);
  const absl::Status deleted = journal_->DeleteMission(name);
  directory_->EndDeletion(name, deleted.ok());
  RETURN_IF_ERROR(deleted);
  // Watchers are called, and find that the mission has gone.
  if (mission != nullptr) mission->CallListeners();
  return absl::OkStatus();
}

absl::StatusOr<MissionBackup> MapStore::BackUpMission(absl::string_view mission_name) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->snapshots().BackUp();
}

MapStore::Memory MapStore::memory() const { return {memory_->limit_bytes(), memory_->refused()}; }

MissionRestorer MapStore::StartRestoring() const {
  return MissionRestorer(options_.max_backup_bytes, [this](uint64_t bytes) {
    return memory_->Check("a backup's piece", bytes);
  });
}

absl::Status MapStore::CheckRoomForMission() const {
  return CheckRoom(directory_->Count(), options_);
}

absl::Status MapStore::ReserveName(const std::string& name) {
  if (leases_ != nullptr) {
    RETURN_IF_ERROR(leases_->CheckReached());
    const absl::Status there = leases_->Look(name).status();
    if (there.ok()) {
      return absl::AlreadyExistsError(absl::StrCat("there is a mission ", name, " already"));
    }
    if (!absl::IsNotFound(there)) return there;
  }
  MakeRoomForMissions(1);
  return directory_->Reserve(
      name, [this](const MissionDirectory::Counts& counts) { return CheckRoom(counts, options_); });
}

absl::Status MapStore::RestoreMission(const std::string& name, MissionState state) {
  RETURN_IF_ERROR(map_store::ValidateName("mission", name));
  RETURN_IF_ERROR(map_store::ValidateRestored(state, options_));
  RETURN_IF_ERROR(ReserveName(name));
  // Under its own name it goes on as what it was, and its robots with it; another name is another
  // mission's.
  if (!IsUidOf(name, state.uid)) state.uid = DrawMissionUid(name);
  state.name = name;
  // Its retention begins anew.
  state.profile.last_used_ns = ToProfileTime(clock_());
  absl::Status status = journal_->CreateMission(name, state);
  std::shared_ptr<Mission> mission = MakeMission(name);
  if (status.ok()) {
    const std::string uid = state.uid;
    mission->Restore(std::move(state));
    LOG(INFO) << "mission " << name << " is restored, uid " << uid;
    mission->profile().NoteUse();
  } else {
    mission.reset();
    if (leases_ != nullptr) leases_->LetGo(name);
  }
  directory_->EndMaking(name, std::move(mission));
  Wake();
  return status;
}

void MapStore::TakePictures(const std::string& name, const Journal& from, absl::string_view there) {
  const absl::StatusOr<std::shared_ptr<Mission>> mission = FindMission(name);
  const uint64_t max_bytes = mission.ok() ? (*mission)->pictures().MaxBytes() : 0;
  if (max_bytes == 0) return;
  const absl::Status taken = from.ForEachPicture(there, [&](const KeyframePicture& picture) {
    return journal_->PutPicture(name, picture, max_bytes);
  });
  LOG_IF(WARNING, !taken.ok()) << "mission " << name
                               << " was restored, but not all of its pictures: " << taken;
}

}  // namespace corbslam::map_store

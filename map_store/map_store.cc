#include "map_store/map_store.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/mission/fusion_executor.h"
#include "map_store/mission/mission.h"
#include "map_store/records/restored_state.h"
#include "slam/util/status_macros.h"

namespace corbslam {

using map_store::FusionExecutor;
using map_store::Mission;

MapStore::MapStore(const MapStoreOptions& options, std::shared_ptr<const Vocabulary> vocabulary,
                   std::unique_ptr<Journal> journal, FusionWorker* worker, Clock clock)
    : options_(options),
      vocabulary_(std::move(vocabulary)),
      journal_(std::move(journal)),
      clock_(std::move(clock)),
      executor_(
          std::make_unique<FusionExecutor>(worker, absl::Milliseconds(options.retry_ms), clock_)) {
  if (options_.deterministic) return;
  const auto list_missions = [this] {
    std::vector<std::shared_ptr<Mission>> missions;
    absl::MutexLock lock(&mutex_);
    for (const auto& [name, mission] : missions_) missions.push_back(mission);
    return missions;
  };
  executor_->Start(list_missions, options_.fusion_threads);
}

MapStore::~MapStore() { executor_->Stop(); }

absl::StatusOr<std::shared_ptr<Mission>> MapStore::FindMission(absl::string_view name) const {
  absl::MutexLock lock(&mutex_);
  const auto it = missions_.find(std::string(name));
  if (it != missions_.end()) return it->second;
  return absl::NotFoundError(absl::StrCat("there is no mission ", name));
}

absl::Status MapStore::Recover() {
  ASSIGN_OR_RETURN(const std::vector<std::string> names, journal_->ListMissions());
  for (const std::string& name : names) {
    std::shared_ptr<Mission> mission = MakeMission(name);
    RETURN_IF_ERROR(mission->Recover());
    absl::MutexLock lock(&mutex_);
    missions_[name] = std::move(mission);
  }
  executor_->Wake();
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<Mission>> MapStore::FindOrCreateMission(const std::string& name) {
  absl::MutexLock lock(&mutex_);
  if (const auto it = missions_.find(name); it != missions_.end()) return it->second;
  if (restoring_.contains(name)) {
    return absl::UnavailableError(absl::StrCat("mission ", name, " is being restored"));
  }
  RETURN_IF_ERROR(CheckRoomForMission());
  return missions_[name] = MakeMission(name);
}

absl::Status MapStore::CheckRoomForMission() const {
  const size_t count = missions_.size() + restoring_.size();
  if (count < options_.max_missions) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat(count, " missions; that is the limit"));
}

std::shared_ptr<Mission> MapStore::MakeMission(const std::string& name) {
  Mission::Environment environment;
  environment.options = &options_;
  environment.vocabulary = vocabulary_.get();
  environment.journal = journal_.get();
  environment.clock = clock_;
  environment.wake_fusion = [this] { executor_->Wake(); };
  environment.has_worker = executor_->has_worker();
  return std::make_shared<Mission>(name, std::move(environment));
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
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindOrCreateMission(request.mission));
  OpenedSession opened;
  {
    absl::MutexLock lock(&mutex_);
    opened.session_id = next_session_++;
  }
  ASSIGN_OR_RETURN(opened.grant, mission->OpenSession(opened.session_id, request));
  absl::MutexLock lock(&mutex_);
  sessions_[opened.session_id] = {request.agent, mission};
  return opened;
}

absl::StatusOr<Acknowledgement> MapStore::Apply(uint64_t session_id, const MapUpdateBatch& batch,
                                                const BatchTransfer* measured) {
  ASSIGN_OR_RETURN(const Session session, FindSession(session_id));
  return session.mission->Apply(session_id, session.agent, batch, measured);
}

void MapStore::CloseSession(uint64_t session_id) {
  const absl::StatusOr<Session> session = FindSession(session_id);
  if (!session.ok()) return;
  session->mission->CloseSession(session_id, session->agent);
  absl::MutexLock lock(&mutex_);
  sessions_.erase(session_id);
}

absl::StatusOr<std::optional<SharedUpdate>> MapStore::NextShared(uint64_t session_id,
                                                                 size_t byte_budget) {
  ASSIGN_OR_RETURN(const Session session, FindSession(session_id));
  return session.mission->NextShared(session_id, session.agent, byte_budget);
}

absl::Status MapStore::AskForExactPlaces(absl::string_view mission_name, const std::string& agent) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->AskForExactPlaces(agent);
}

bool MapStore::TakeExactPlacesWanted(uint64_t session_id) {
  const absl::StatusOr<Session> session = FindSession(session_id);
  return session.ok() && session->mission->TakeExactPlacesWanted(session->agent);
}

void MapStore::SetSharedListener(uint64_t session_id, std::function<void()> listener) {
  const absl::StatusOr<Session> session = FindSession(session_id);
  if (session.ok()) session->mission->SetSharedListener(session_id, std::move(listener));
}

absl::Status MapStore::RunFusionUntilIdle(absl::string_view mission_name) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  executor_->RunUntilIdle(*mission);
  return absl::OkStatus();
}

absl::Status MapStore::RederiveGlobalLayer(absl::string_view mission_name) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->Rederive();
}

absl::StatusOr<std::vector<uint64_t>> MapStore::RetractOverlap(absl::string_view mission_name,
                                                               uint64_t overlap, bool keep_apart) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->RetractOverlap(overlap, keep_apart);
}

absl::StatusOr<bool> MapStore::IsFusionIdle(absl::string_view mission_name) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->IsFusionIdle();
}

absl::Status MapStore::WaitUntilFusionIdle(absl::string_view mission_name,
                                           absl::Duration timeout) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  if (mission->WaitUntilFusionIdle(absl::Now() + timeout)) return absl::OkStatus();
  return absl::DeadlineExceededError(absl::StrCat(
      "fusion of mission ", mission_name, " is busy after ", absl::FormatDuration(timeout)));
}

absl::Status MapStore::DeleteMission(absl::string_view mission_name) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  // Who waited for another one's deletion must not delete what has got the name since.
  absl::MutexLock deleting(&deletion_mutex_);
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> still, FindMission(mission_name));
  if (still != mission) {
    return absl::NotFoundError(absl::StrCat("mission ", mission_name, " is deleted"));
  }
  // Nothing is appended any more: what is deleted stays so.
  mission->Delete();
  RETURN_IF_ERROR(journal_->DeleteMission(mission_name));
  {
    absl::MutexLock lock(&mutex_);
    missions_.erase(std::string(mission_name));
  }
  // Who watches finds that it has gone.
  mission->NotifyAll(0);
  return absl::OkStatus();
}

absl::StatusOr<MissionBackup> MapStore::BackUpMission(absl::string_view mission_name) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->WithState(
      [](const map_store::MissionState& state) { return MissionBackup(state); });
}

MissionRestorer MapStore::StartRestoring() const {
  return MissionRestorer(options_.max_backup_bytes);
}

absl::Status MapStore::RestoreMission(const std::string& name, map_store::MissionState state) {
  RETURN_IF_ERROR(map_store::ValidateName("mission", name));
  RETURN_IF_ERROR(map_store::ValidateRestored(state, options_));
  {
    absl::MutexLock lock(&mutex_);
    if (missions_.contains(name) || restoring_.contains(name)) {
      return absl::AlreadyExistsError(absl::StrCat("there is a mission ", name, " already"));
    }
    RETURN_IF_ERROR(CheckRoomForMission());
    restoring_.insert(name);
  }
  state.name = name;
  absl::Status status = journal_->CreateMission(name, state);
  std::shared_ptr<Mission> mission = MakeMission(name);
  if (status.ok()) mission->Restore(std::move(state));
  {
    absl::MutexLock lock(&mutex_);
    restoring_.erase(name);
    if (status.ok()) missions_[name] = std::move(mission);
  }
  executor_->Wake();
  return status;
}

}  // namespace corbslam

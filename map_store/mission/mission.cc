#include "map_store/mission/mission.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/ingest/parked_references.h"
#include "map_store/ingest/quota.h"
#include "map_store/records/record_application.h"
#include "map_store/sharing/sharing.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// About what items take on the wire, where the transport does not say.
BatchTransfer EstimateTransfer(const MapUpdateBatch& batch) {
  constexpr uint64_t kBytesPerKeypoint = 48;
  BatchTransfer transfer;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    transfer.full_keyframe_bytes +=
        100 + kBytesPerKeypoint * keyframe.payload->features.keypoints.size();
  }
  transfer.full_map_point_bytes = 90 * batch.full_points.size();
  transfer.light_keyframe_bytes = 70 * batch.light_keyframes.size();
  transfer.light_map_point_bytes = 30 * batch.light_points.size();
  return transfer;
}

void Count(TransferStatistics& statistics, size_t items, uint64_t bytes, double ms) {
  statistics.count += items;
  statistics.bytes += bytes;
  statistics.ms += ms;
}

absl::Status CheckNumber(const LocalMapState* local_map, const MapUpdateBatch& batch,
                         std::optional<Acknowledgement>& known) {
  const uint64_t last = local_map == nullptr ? 0 : local_map->last_batch;
  if (batch.number == 0) return absl::InvalidArgumentError("batch without a number");
  if (batch.number <= last) {
    known = Acknowledgement{batch.local_map, last};
    return absl::OkStatus();
  }
  if (batch.number == last + 1) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("batch ", batch.number, " of local map ",
                                                    ToString(batch.local_map), ": expected ",
                                                    last + 1));
}

// Two processes of one name would throw each other out for ever. A process that comes back takes
// its own older session's place, and so does an agent that says nothing of processes.
absl::Status CheckNotHeld(absl::string_view mission, const AgentState& agent,
                          const SessionRequest& request) {
  const bool is_held = agent.session != 0 && request.instance != 0 &&
                       request.instance != agent.instance && !request.take_over;
  if (!is_held) return absl::OkStatus();
  return absl::AlreadyExistsError(absl::StrCat(
      "agent ", request.agent, " of mission ", mission,
      " is connected already, as another process, since ",
      absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", agent.session_begin, absl::UTCTimeZone()),
      agent.peer.empty() ? "" : " from ", agent.peer,
      ": give this robot another name (--agent), stop that process, or start this one with "
      "--take-over; if that process or its link is gone, its session ends within a minute"));
}

}  // namespace

Mission::Mission(std::string name, Environment environment)
    : name_(std::move(name)), environment_(std::move(environment)) {
  state_.name = name_;
}

absl::StatusOr<SessionGrant> Mission::OpenSession(uint64_t session_id,
                                                  const SessionRequest& request) {
  SessionGrant grant;
  grant.capabilities = {.points_follow = true, .coded_features = true};
  uint64_t fenced = 0;
  {
    absl::MutexLock lock(&mutex_);
    if (deleted_) return Deleted();
    if (const auto it = state_.agents.find(request.agent); it != state_.agents.end()) {
      RETURN_IF_ERROR(CheckNotHeld(name_, it->second, request));
    }
    for (const LocalMapId& id : request.local_maps) {
      const LocalMapState* local_map = state_.FindLocalMap(id);
      if (local_map != nullptr && local_map->agent != request.agent) {
        return absl::PermissionDeniedError(
            absl::StrCat("local map ", ToString(id), " is another agent's"));
      }
      if (LocalMapState* own = state_.FindLocalMap(id); own != nullptr) {
        ExpireParked(environment_.clock(), *environment_.options, *own);
      }
      grant.acknowledged.push_back({id, local_map == nullptr ? 0 : local_map->last_batch});
    }
    const size_t agents = state_.agents.size();
    if (agents >= environment_.options->max_agents_per_mission &&
        !state_.agents.contains(request.agent)) {
      return absl::ResourceExhaustedError(
          absl::StrCat("mission ", name_, " has ", agents, " agents; that is the limit"));
    }
    AgentState& agent = state_.agents[request.agent];
    fenced = std::exchange(agent.session, session_id);
    agent.instance = request.instance;
    agent.session_begin = environment_.clock();
    agent.peer = request.peer;
    Told& told = told_[request.agent];
    absl::MutexLock telling(&told.mutex);
    ResumeSharing(request.last_revision, told.share);
    ++state_.version;
  }
  // The robot forgets what the grant acknowledges.
  if (const absl::Status durable = SyncJournal(); !durable.ok()) {
    absl::MutexLock lock(&mutex_);
    uint64_t& session = state_.agents.at(request.agent).session;
    if (session == session_id) session = 0;
    return durable;
  }
  std::function<void()> listener;
  {
    absl::MutexLock lock(&listener_mutex_);
    if (const auto it = shared_listeners_.find(fenced); it != shared_listeners_.end()) {
      listener = std::move(it->second);
      shared_listeners_.erase(it);
    }
  }
  if (listener) listener();
  return grant;
}

absl::Status Mission::CheckSession(uint64_t session_id, const std::string& agent) const {
  if (deleted_) return absl::AbortedError(absl::StrCat("mission ", name_, " was deleted"));
  const auto it = state_.agents.find(agent);
  if (it != state_.agents.end() && it->second.session == session_id) return absl::OkStatus();
  return absl::AbortedError(
      absl::StrCat("a newer session of agent ", agent, " has taken the place of this one"));
}

absl::Status Mission::CheckBatch(uint64_t session_id, const std::string& agent,
                                 const MapUpdateBatch& batch,
                                 std::optional<Acknowledgement>& known) const {
  RETURN_IF_ERROR(CheckSession(session_id, agent));
  const LocalMapState* local_map = state_.FindLocalMap(batch.local_map);
  if (local_map != nullptr && local_map->agent != agent) {
    return absl::PermissionDeniedError(
        absl::StrCat("local map ", ToString(batch.local_map), " is another agent's"));
  }
  if (local_map == nullptr &&
      state_.local_maps.size() >= environment_.options->max_local_maps_per_mission) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "mission ", name_, " has ", state_.local_maps.size(), " local maps; that is the limit"));
  }
  RETURN_IF_ERROR(CheckNumber(local_map, batch, known));
  return known.has_value() ? absl::OkStatus()
                           : CheckQuota(state_, agent, batch, *environment_.options);
}

absl::StatusOr<Acknowledgement> Mission::Apply(uint64_t session_id, const std::string& agent,
                                               const MapUpdateBatch& batch,
                                               const BatchTransfer* measured) {
  const absl::Time begin = environment_.clock();
  std::optional<Acknowledgement> known;
  {
    absl::ReaderMutexLock lock(&mutex_);
    RETURN_IF_ERROR(CheckBatch(session_id, agent, batch, known));
    if (!known.has_value()) {
      RETURN_IF_ERROR(
          ValidateBatch(state_.FindLocalMap(batch.local_map), batch, *environment_.options));
    }
  }
  if (!known.has_value()) {
    const BatchWords words = ComputeWords(batch, environment_.vocabulary);
    absl::MutexLock turn(&writer_mutex_);
    {
      absl::ReaderMutexLock lock(&mutex_);
      // As long as this is the next batch, its local map is as it was validated against.
      RETURN_IF_ERROR(CheckBatch(session_id, agent, batch, known));
    }
    if (!known.has_value()) {
      RETURN_IF_ERROR(ApplyNext(agent, batch, words));
      absl::MutexLock lock(&mutex_);
      CountTransfer(batch, measured, absl::ToDoubleMilliseconds(environment_.clock() - begin));
    }
  }
  // Others' batches become durable together with this one; a batch that came again may not be yet.
  RETURN_IF_ERROR(SyncJournal());
  if (known.has_value()) return *known;
  environment_.wake_fusion();
  NotifyAll(session_id);
  return Acknowledgement{batch.local_map, batch.number};
}

absl::Status Mission::ApplyNext(const std::string& agent, const MapUpdateBatch& batch,
                                const BatchWords& words) {
  BatchRecord record{agent, nullptr, environment_.clock()};
  {
    absl::ReaderMutexLock lock(&mutex_);
    record.batch = WithoutKnownKeyframes(batch, state_.FindLocalMap(batch.local_map));
  }
  RETURN_IF_ERROR(Append(record));
  absl::MutexLock lock(&mutex_);
  map_store::Apply(record, words, *environment_.options, state_);
  return absl::OkStatus();
}

absl::Status Mission::Deleted() const {
  return absl::NotFoundError(absl::StrCat("mission ", name_, " is deleted"));
}

bool Mission::IsDeleted() const {
  absl::ReaderMutexLock lock(&mutex_);
  return deleted_;
}

absl::Status Mission::Append(const JournalRecord& record) {
  ASSIGN_OR_RETURN(appended_, environment_.journal->Append(name_, record));
  return absl::OkStatus();
}

absl::Status Mission::SyncJournal() { return environment_.journal->Sync(appended_); }

void Mission::CountTransfer(const MapUpdateBatch& batch, const BatchTransfer* measured, double ms) {
  const BatchTransfer transfer = measured != nullptr ? *measured : EstimateTransfer(batch);
  const double bytes =
      static_cast<double>(transfer.full_keyframe_bytes + transfer.full_map_point_bytes +
                          transfer.light_keyframe_bytes + transfer.light_map_point_bytes);
  // The batch's time, shared out by bytes.
  const double ms_per_byte = bytes > 0 ? ms / bytes : 0;
  const auto count = [ms_per_byte](TransferStatistics& statistics, size_t items, uint64_t size) {
    Count(statistics, items, size, ms_per_byte * static_cast<double>(size));
  };
  MissionStatistics& statistics = state_.statistics;
  count(statistics.full_keyframes, batch.full_keyframes.size(), transfer.full_keyframe_bytes);
  count(statistics.full_map_points, batch.full_points.size(), transfer.full_map_point_bytes);
  count(statistics.light_keyframes, batch.light_keyframes.size(), transfer.light_keyframe_bytes);
  count(statistics.light_map_points, batch.light_points.size(), transfer.light_map_point_bytes);
}

void Mission::CloseSession(uint64_t session_id, const std::string& agent) {
  {
    absl::MutexLock lock(&mutex_);
    const auto it = state_.agents.find(agent);
    if (it != state_.agents.end() && it->second.session == session_id) it->second.session = 0;
  }
  SetSharedListener(session_id, nullptr);
  environment_.wake_fusion();
}

absl::StatusOr<std::optional<SharedUpdate>> Mission::NextShared(uint64_t session_id,
                                                                const std::string& agent,
                                                                size_t byte_budget) {
  absl::ReaderMutexLock lock(&mutex_);
  RETURN_IF_ERROR(CheckSession(session_id, agent));
  Told& told = told_.at(agent);
  absl::MutexLock telling(&told.mutex);
  return TakeSharedUpdate(state_, *environment_.options, byte_budget, state_.agents.at(agent),
                          told.share);
}

absl::Status Mission::AskForExactPlaces(const std::string& agent_name) {
  uint64_t session = 0;
  {
    absl::ReaderMutexLock lock(&mutex_);
    if (deleted_) return Deleted();
    const auto agent = state_.agents.find(agent_name);
    if (agent == state_.agents.end()) {
      return absl::NotFoundError(absl::StrCat("mission ", name_, " has no agent ", agent_name));
    }
    session = agent->second.session;
    if (session == 0) {
      return absl::FailedPreconditionError(
          absl::StrCat("agent ", agent_name, " is not connected, and can't be asked"));
    }
    Told& told = told_.at(agent_name);
    absl::MutexLock telling(&told.mutex);
    told.exact_places_wanted = true;
  }
  if (const std::function<void()> listener = SharedListener(session)) listener();
  return absl::OkStatus();
}

bool Mission::TakeExactPlacesWanted(const std::string& agent) {
  absl::ReaderMutexLock lock(&mutex_);
  const auto told = told_.find(agent);
  if (told == told_.end()) return false;
  absl::MutexLock telling(&told->second.mutex);
  return std::exchange(told->second.exact_places_wanted, false);
}

void Mission::SetSharedListener(uint64_t session_id, std::function<void()> listener) {
  absl::MutexLock lock(&listener_mutex_);
  if (listener == nullptr) {
    shared_listeners_.erase(session_id);
  } else {
    shared_listeners_[session_id] = std::move(listener);
  }
}

uint64_t Mission::AddMapListener(std::function<void()> listener) {
  static std::atomic<uint64_t> next_token = 1;
  const uint64_t token = next_token++;
  absl::MutexLock lock(&listener_mutex_);
  map_listeners_[token] = std::move(listener);
  return token;
}

void Mission::RemoveMapListener(uint64_t token) {
  absl::MutexLock lock(&listener_mutex_);
  map_listeners_.erase(token);
}

std::function<void()> Mission::SharedListener(uint64_t session_id) const {
  absl::MutexLock lock(&listener_mutex_);
  const auto it = shared_listeners_.find(session_id);
  return it == shared_listeners_.end() ? nullptr : it->second;
}

std::vector<std::function<void()>> Mission::ListenersExcept(uint64_t session_id) const {
  std::vector<std::function<void()>> listeners;
  absl::MutexLock lock(&listener_mutex_);
  for (const auto& [id, listener] : shared_listeners_) {
    if (id != session_id) listeners.push_back(listener);
  }
  for (const auto& [token, listener] : map_listeners_) listeners.push_back(listener);
  return listeners;
}

void Mission::NotifyAll(uint64_t except_session) {
  for (const std::function<void()>& listener : ListenersExcept(except_session)) listener();
}

void Mission::Delete() {
  {
    absl::MutexLock turn(&writer_mutex_);
    absl::MutexLock lock(&mutex_);
    deleted_ = true;
    state_.queries.Clear();
    for (Lane& lane : lanes_) {
      if (lane.cancelled != nullptr) lane.cancelled->store(true);
    }
    lane_released_.SignalAll();
  }
  // A snapshot that has begun must not come behind the deletion.
  { absl::MutexLock ended(&snapshot_mutex_); }
  NotifyAll(0);
}

}  // namespace corbslam::map_store

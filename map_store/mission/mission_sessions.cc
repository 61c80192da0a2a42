#include "map_store/mission/mission_sessions.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/parked_references.h"
#include "map_store/mission/pausing_read.h"
#include "map_store/sharing/share_memory.h"
#include "map_store/sharing/sharing.h"
#include "slam/exchange/session_end.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Refuses a second process of an agent's name: two would throw each other out for ever. A process
// that comes back takes its own older session's place, and so does an agent that says nothing of
// processes.
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

absl::Status MissionSessions::CheckRequest(const SessionRequest& request) const {
  const MissionState& state = strand_.state();
  const auto agent = state.agents.find(request.agent);
  RETURN_IF_ERROR(strand_.refusal());
  if (strand_.deleted()) {
    const bool was_here = request.mission_uid.empty()
                              ? agent != state.agents.end() && request.instance != 0 &&
                                    agent->second.instance == request.instance
                              : request.mission_uid == state.uid;
    return was_here ? MissionDeletedError(strand_.name()) : strand_.Deleted();
  }
  if (agent != state.agents.end()) {
    RETURN_IF_ERROR(CheckNotHeld(strand_.name(), agent->second, request));
  }
  for (const LocalMapId& id : request.local_maps) {
    const LocalMapState* local_map = state.FindLocalMap(id);
    if (local_map == nullptr || local_map->agent == request.agent) continue;
    return absl::PermissionDeniedError(
        absl::StrCat("local map ", ToString(id), " is another agent's"));
  }
  const size_t agents = state.agents.size();
  if (agent != state.agents.end() || agents < strand_.options().max_agents_per_mission) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(
      absl::StrCat("mission ", strand_.name(), " has ", agents, " agents; that is the limit"));
}

absl::StatusOr<MissionSessions::Opened> MissionSessions::Enter(uint64_t session_id,
                                                               const SessionRequest& request) {
  StateWriteLock lock(strand_);
  RETURN_IF_ERROR(CheckRequest(request));
  MissionState& state = strand_.mutable_state();
  const absl::Time now = strand_.environment().clock();
  Opened opened;
  opened.grant.mission_uid = state.uid;
  opened.grant.capabilities = {
      .points_follow = true,
      .coded_features = true,
      .localise_only = true,
      .keeps_localised = true,
      .keyframe_pictures = strand_.options().max_picture_bytes_per_mission > 0,
      .takes_reports = true};
  for (const LocalMapId& id : request.local_maps) {
    LocalMapState* local_map = state.FindLocalMap(id);
    if (local_map != nullptr) ExpireParked(now, strand_.options(), *local_map);
    opened.grant.acknowledged.push_back({id, LastBatchOf(state, id)});
  }
  AgentState& agent = state.agents[request.agent];
  opened.fenced = std::exchange(agent.session, session_id);
  Told& told = told_[request.agent];
  told.left_on_purpose = false;
  if (agent.instance != request.instance) {
    // What another process said of itself is not this one's.
    absl::MutexLock noting(&told.report_mutex);
    told.report.reset();
  }
  agent.instance = request.instance;
  agent.session_begin = now;
  agent.peer = request.peer;
  agent.localise_only = request.localise_only;
  agent.localised.reset();
  agent.localised_lost_ns = -1;
  opened.told = &told;
  ++state.version;
  return opened;
}

absl::StatusOr<SessionGrant> MissionSessions::Open(uint64_t session_id,
                                                   const SessionRequest& request) {
  ASSIGN_OR_RETURN(Opened opened, Enter(session_id, request));
  {
    // The lock is free once the session before has stopped telling the robot.
    absl::MutexLock telling(&opened.told->mutex);
    ResumeSharing(request.last_revision, request.share, opened.told->share);
    opened.told->wants_nothing = request.share.mode == ShareMode::kNone;
    opened.told->updates = 0;
    opened.told->complete_at_version = opened.told->share.complete_at_version;
  }
  // The robot comes back by the uid, and forgets the acknowledged batches: both must be durable.
  absl::Status durable = strand_.PromiseUid();
  if (durable.ok()) durable = strand_.Sync();
  if (!durable.ok()) {
    Leave(session_id, request.agent, /*has_joined=*/opened.fenced != 0, /*on_purpose=*/false);
    return durable;
  }
  listeners_.CallLast(opened.fenced);
  NoteJoined(session_id, request.agent);
  return std::move(opened.grant);
}

absl::Status CheckSession(const MissionStrand& strand, uint64_t session_id,
                          const std::string& agent) {
  RETURN_IF_ERROR(strand.refusal());
  if (strand.deleted()) return strand.SessionEnd();
  const auto& agents = strand.state().agents;
  const auto it = agents.find(agent);
  if (it != agents.end() && it->second.session == session_id) return absl::OkStatus();
  return absl::AbortedError(
      absl::StrCat("a newer session of agent ", agent, " has taken the place of this one"));
}

void MissionSessions::NoteJoined(uint64_t session_id, const std::string& agent) {
  {
    absl::MutexLock coming(&coming_);
    const bool is_here = strand_.WithState(
        [&](const MissionState& state) { return state.agents.at(agent).session == session_id; });
    if (is_here) events_.Note(strand_.Revision(), MissionEvent::AgentJoined{agent});
  }
  events_.Tell();
}

void MissionSessions::Leave(uint64_t session_id, const std::string& agent, bool has_joined,
                            bool on_purpose) {
  {
    absl::MutexLock coming(&coming_);
    bool was_here = false;
    {
      StateWriteLock lock(strand_);
      auto& agents = strand_.mutable_state().agents;
      const auto it = agents.find(agent);
      was_here = it != agents.end() && it->second.session == session_id;
      if (was_here) it->second.session = 0;
      if (was_here) told_[agent].left_on_purpose = on_purpose;
    }
    if (was_here && has_joined) {
      events_.Note(strand_.Revision(), MissionEvent::AgentLeft{agent, on_purpose});
    }
  }
  events_.Tell();
}

void MissionSessions::Close(uint64_t session_id, const std::string& agent, bool on_purpose) {
  Leave(session_id, agent, /*has_joined=*/true, on_purpose);
  listeners_.SetOfSession(session_id, nullptr);
  if (on_purpose) ForgetTold(agent);
  strand_.environment().wake_fusion();
}

absl::StatusOr<std::optional<SharedUpdate>> MissionSessions::NextShared(uint64_t session_id,
                                                                        const std::string& agent,
                                                                        size_t byte_budget) {
  Told* told = FindTold(agent);
  if (told == nullptr) return absl::AbortedError(absl::StrCat("agent ", agent, " has no session"));
  absl::MutexLock telling(&told->mutex);
  absl::StatusOr<std::optional<SharedUpdate>> update;
  do {
    update = PollUpdate(session_id, agent, byte_budget, told->share);
  } while (update.ok() && !update->has_value() && told->share.unfinished);
  if (!update.ok()) ForgetLastUpdate(told->share);
  told->complete_at_version = told->share.complete_at_version;
  if (update.ok() && update->has_value()) ++told->updates;
  return update;
}

absl::Status MissionSessions::NoteReport(uint64_t session_id, const std::string& agent,
                                         const AgentReport& report) {
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    RETURN_IF_ERROR(CheckSession(strand_, session_id, agent));
    Told& told = told_.at(agent);
    absl::MutexLock noting(&told.report_mutex);
    NoteContradictions(agent, told.report, report);
    told.report = report;
    told.report_came = strand_.environment().clock();
  }
  events_.Tell();
  return absl::OkStatus();
}

void MissionSessions::NoteContradictions(const std::string& agent,
                                         const std::optional<AgentReport>& before,
                                         const AgentReport& now) {
  const MissionState& state = strand_.state();
  for (const MapContradiction& found : now.contradictions) {
    const LocalMapState* others = state.FindLocalMap(found.local_map);
    if (others == nullptr || others->agent == agent) continue;
    const bool is_known =
        before.has_value() &&
        std::ranges::any_of(before->contradictions, [&](const MapContradiction& earlier) {
          return earlier.local_map == found.local_map;
        });
    if (is_known) continue;
    events_.Note(state.global.revision, MissionEvent::MapContradicted{agent, others->agent, found});
  }
}

void MissionSessions::DescribeTold(std::vector<AgentInfo>& agents) const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  for (AgentInfo& agent : agents) DescribeTold(agent);
}

namespace {

// Returns the island that the agent is told of; null if there is nothing to tell: its local map was
// merged with none.
const Island* FindToldIsland(const MissionState& state, const AgentInfo& agent) {
  if (agent.localise_only) {
    const auto it = state.global.islands.find(state.ReferenceIsland());
    return it == state.global.islands.end() ? nullptr : &it->second;
  }
  const LocalMapState* own = FindOwnLocalMap(state, agent.local_maps);
  if (own == nullptr) return nullptr;
  const Island* island = state.FindIslandOf(own->id);
  return island == nullptr || island->local_maps.size() < 2 ? nullptr : island;
}

}  // namespace

void MissionSessions::DescribeTold(AgentInfo& agent) const {
  const auto told = told_.find(agent.name);
  if (told == told_.end()) return;
  agent.left_on_purpose = !agent.connected && told->second.left_on_purpose;
  {
    absl::MutexLock reading(&told->second.report_mutex);
    agent.report = told->second.report;
    if (agent.report.has_value()) {
      agent.report_age =
          std::max(strand_.environment().clock() - told->second.report_came, absl::ZeroDuration());
    }
  }
  if (!agent.connected) return;
  agent.shared_updates = told->second.updates;
  const MissionState& state = strand_.state();
  const Island* island = FindToldIsland(state, agent);
  agent.up_to_date = told->second.wants_nothing || island == nullptr ||
                     told->second.complete_at_version == island->shared_version;
}

absl::StatusOr<std::optional<SharedUpdate>> MissionSessions::PollUpdate(uint64_t session_id,
                                                                        const std::string& agent,
                                                                        size_t byte_budget,
                                                                        ShareState& share) const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  const auto check = [&]() ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex()) {
    return CheckSession(strand_, session_id, agent);
  };
  RETURN_IF_ERROR(check());
  PausingRead read(strand_, check);
  std::optional<SharedUpdate> update =
      TakeSharedUpdate(strand_.state(), strand_.options(), byte_budget,
                       strand_.state().agents.at(agent), share, read);
  strand_.state().told.Set(agent, EstimateMemory(share));
  RETURN_IF_ERROR(check());
  return update;
}

void MissionSessions::ForgetTold(const std::string& agent) {
  Told* told = FindTold(agent);
  if (told == nullptr) return;
  absl::MutexLock telling(&told->mutex);
  absl::ReaderMutexLock lock(&strand_.mutex());
  // A session that has begun since is told, or finds nothing that it could go on from.
  const auto here = strand_.state().agents.find(agent);
  if (here != strand_.state().agents.end() && here->second.session != 0) return;
  EndSharing(told->share);
  strand_.state().told.Set(agent, 0);
}

MissionSessions::Told* MissionSessions::FindTold(const std::string& agent) {
  absl::ReaderMutexLock lock(&strand_.mutex());
  const auto it = told_.find(agent);
  return it == told_.end() ? nullptr : &it->second;
}

absl::Status MissionSessions::AskForExactPlaces(const std::string& agent_name) {
  uint64_t session = 0;
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    if (strand_.deleted()) return strand_.Deleted();
    const auto agent = strand_.state().agents.find(agent_name);
    if (agent == strand_.state().agents.end()) {
      return absl::NotFoundError(
          absl::StrCat("mission ", strand_.name(), " has no agent ", agent_name));
    }
    session = agent->second.session;
    if (session == 0) {
      return absl::FailedPreconditionError(
          absl::StrCat("agent ", agent_name, " is not connected, and can't be asked"));
    }
    told_.at(agent_name).exact_places_wanted = true;
  }
  listeners_.Call(session);
  return absl::OkStatus();
}

bool MissionSessions::TakeExactPlacesWanted(const std::string& agent) {
  absl::ReaderMutexLock lock(&strand_.mutex());
  const auto told = told_.find(agent);
  return told != told_.end() && told->second.exact_places_wanted.exchange(false);
}

}  // namespace corbslam::map_store

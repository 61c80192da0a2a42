#include "map_store/view/last_pose.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "map_store/state/session_frames.h"
#include "map_store/view/localised_trajectory.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

// Frames that are looked at before a local map counts as one without any pose.
constexpr size_t kMaxTries = 100;

std::optional<Rigid3d> CameraFromIsland(const MissionState& state, const LocalMapState& local_map,
                                        const TrackedFrame& frame) {
  LivingRelative relative;
  if (!FindLivingRelative(state, frame.reference, relative)) return std::nullopt;
  const LocalMapId of_relative = relative.id.local_map;
  if (state.global.island_of.at(of_relative) != state.global.island_of.at(local_map.id)) {
    return std::nullopt;
  }
  const auto table = FindPoses(state, *state.FindLocalMap(of_relative));
  const Rigid3d relative_from_camera = relative.relative_from_id * frame.reference_from_camera;
  return relative_from_camera.Inverse() * table->poses.at(relative.id).ToRigid();
}

// A start of the agent, and when its local map arrived.
struct Session {
  const LocalMapState* local_map = nullptr;
  SessionFrames frames;
  uint64_t arrival = 0;
};

// Returns the agent's sessions, the newest first. Their clocks may begin anew with each start:
// which one is newer the times do not say.
std::vector<Session> NewestSessions(const MissionState& state, const AgentState& agent) {
  std::vector<Session> sessions;
  for (const LocalMapId& id : agent.local_maps) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    for (const SessionFrames& frames : SessionsOf(local_map)) {
      sessions.push_back({&local_map, frames, state.arrivals.NumberOf(frames.id)});
    }
  }
  std::ranges::sort(sessions, std::greater(), &Session::arrival);
  return sessions;
}

std::optional<LastPose> FindIn(const MissionState& state, const Session& session) {
  const LocalMapState& local_map = *session.local_map;
  const SessionFrames& frames = session.frames;
  if (frames.first == frames.end) return std::nullopt;
  const size_t newest = std::clamp(frames.newest_frame, frames.first, frames.end - 1);
  for (size_t tries = 0; tries < kMaxTries && tries <= newest - frames.first; ++tries) {
    const TrackedFrame& frame = local_map.frames[newest - tries];
    const auto pose = CameraFromIsland(state, local_map, frame);
    if (!pose.has_value()) continue;
    const IslandId island = state.global.island_of.at(local_map.id);
    return LastPose{.timestamp_ns = frame.timestamp_ns,
                    .local_map = local_map.id,
                    .island = island,
                    .in_reference_island = island == state.ReferenceIsland(),
                    .camera_from_island = *pose,
                    .lost_since = frames.newest_lost_ns > frame.timestamp_ns};
  }
  return std::nullopt;
}

// As the store keeps it of an agent that localised only.
std::optional<LastPose> OfTrack(const MissionState& state, const AgentState& agent) {
  bool lost_later = false;
  for (auto run = agent.track.runs.rbegin(); run != agent.track.runs.rend(); ++run) {
    lost_later |=
        !run->lost_frames_ns.empty() &&
        (run->frames.empty() || run->lost_frames_ns.back() > run->frames.back().timestamp_ns);
    if (run->frames.empty()) continue;
    const TrackedFrame& frame = run->frames.back();
    const std::optional<PlaceInIsland> place = PlaceLocalised(state, frame);
    if (!place.has_value()) return std::nullopt;
    return LastPose{.timestamp_ns = frame.timestamp_ns,
                    .local_map = {},
                    .island = place->island,
                    .in_reference_island = place->island == state.ReferenceIsland(),
                    .camera_from_island = place->island_from_camera.Inverse(),
                    .lost_since = lost_later};
  }
  return std::nullopt;
}

// As the session says that localises only.
std::optional<LastPose> SaidByItself(const MissionState& state, const AgentState& agent) {
  if (!agent.localised.has_value()) return OfTrack(state, agent);
  const LocalisedFrame& frame = *agent.localised;
  return LastPose{.timestamp_ns = frame.timestamp_ns,
                  .local_map = {},
                  .island = state.ReferenceIsland(),
                  .in_reference_island = true,
                  .camera_from_island = *frame.camera_from_global,
                  .lost_since = agent.localised_lost_ns > frame.timestamp_ns};
}

}  // namespace

std::optional<LastPose> FindLastPose(const MissionState& state, const AgentState& agent) {
  if (agent.localise_only) return SaidByItself(state, agent);
  bool lost_later = false;
  for (const Session& session : NewestSessions(state, agent)) {
    if (std::optional<LastPose> pose = FindIn(state, session)) {
      pose->lost_since |= lost_later;
      return pose;
    }
    lost_later |= session.frames.first_lost < session.frames.end_lost;
  }
  return OfTrack(state, agent);
}

}  // namespace corbslam::map_store

// MapStore's look-ups. Each finds its mission and reads the answer under the mission's lock.
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/fusion/overlap_matches.h"
#include "map_store/process/fusion_executor.h"
#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/store/map_store.h"
#include "map_store/view/answers.h"
#include "map_store/view/sights.h"
#include "map_store/view/trajectory.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

bool MapStore::has_worker() const { return executor_->has_worker(); }

std::optional<WorkerOutage> MapStore::worker_outage() const { return executor_->worker_outage(); }

absl::StatusOr<MissionInfo> MapStore::GetMission(absl::string_view mission_name) const {
  const absl::StatusOr<KnownMission> known = directory_->Peek(mission_name);
  if (leases_ != nullptr && absl::IsNotFound(known.status())) return GetShared(mission_name);
  RETURN_IF_ERROR(known.status());
  return Describe(*known);
}

absl::StatusOr<LocalMapInfo> MapStore::GetLocalMap(absl::string_view mission_name,
                                                   LocalMapId id) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->WithState([id](const MissionState& state) -> absl::StatusOr<LocalMapInfo> {
    const LocalMapState* local_map = state.FindLocalMap(id);
    if (local_map == nullptr) return map_store::NoSuchLocalMap(id);
    return map_store::DescribeLocalMap(state, *local_map);
  });
}

absl::StatusOr<KeyframeInfo> MapStore::GetKeyframe(absl::string_view mission_name, KeyframeId id,
                                                   bool with_sights) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->WithState([&](const MissionState& state) -> absl::StatusOr<KeyframeInfo> {
    const Keyframe* const keyframe = state.FindKeyframe(id);
    if (keyframe == nullptr) {
      return absl::NotFoundError(absl::StrCat("there is no keyframe ", ToString(id)));
    }
    KeyframeInfo info = map_store::DescribeKeyframes(state, {id}).front();
    if (with_sights) {
      info.sights = map_store::SightsOf(state, *state.FindLocalMap(id.local_map), *keyframe);
    }
    return info;
  });
}

absl::StatusOr<std::optional<KeyframePicture>> MapStore::GetPicture(absl::string_view mission_name,
                                                                    KeyframeId id) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  if (!mission->WithState([id](const MissionState& state) { return state.FindKeyframe(id); })) {
    return absl::NotFoundError(absl::StrCat("there is no keyframe ", ToString(id)));
  }
  absl::StatusOr<KeyframePicture> picture = journal_->ReadPicture(mission_name, id);
  if (absl::IsNotFound(picture.status())) return std::nullopt;
  RETURN_IF_ERROR(picture.status());
  return *std::move(picture);
}

absl::StatusOr<OverlapInfo> MapStore::GetOverlap(absl::string_view mission_name,
                                                 uint64_t overlap) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  OverlapInfo info;
  std::optional<OverlapSides> sides;
  RETURN_IF_ERROR(mission->WithState([&](const MissionState& state) {
    const OverlapEntry* const entry = state.global.overlaps.Find(overlap);
    if (entry == nullptr) {
      return absl::NotFoundError(absl::StrCat("there is no overlap ", overlap,
                                              "; of those that are no part of the map, the newest ",
                                              OverlapLedger::kMaxHistory, " are remembered"));
    }
    info = map_store::DescribeOverlap(state, *entry);
    sides = map_store::TakeOverlapSides(state, entry->overlap);
    return absl::OkStatus();
  }));
  if (!sides.has_value()) return info;
  for (const auto& [query, candidate] : map_store::MatchOverlap(*sides)) {
    info.matches.emplace_back(sides->query.keypoints()[query].Pixel(),
                              sides->candidate.keypoints()[candidate].Pixel());
  }
  return info;
}

absl::StatusOr<MissionStatistics> MapStore::GetStatistics(absl::string_view mission_name) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->WithState(DescribeStatistics);
}

absl::StatusOr<std::vector<AgentTrajectory>> MapStore::GetTrajectory(absl::string_view mission_name,
                                                                     absl::string_view agent,
                                                                     TrajectoryFrame frame,
                                                                     bool all_islands,
                                                                     PosesOf poses_of) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  std::vector<AgentTrajectory> trajectories;
  RETURN_IF_ERROR(mission->WithState([&](const MissionState& state) -> absl::Status {
    for (const auto& [name, agent_state] : state.agents) {
      if (!agent.empty() && agent != name) continue;
      ASSIGN_OR_RETURN(trajectories.emplace_back(),
                       map_store::ComputeTrajectory(state, name, frame, all_islands, poses_of));
    }
    return absl::OkStatus();
  }));
  if (trajectories.empty() && !agent.empty()) {
    return absl::NotFoundError(absl::StrCat("there is no agent ", agent));
  }
  return trajectories;
}

absl::StatusOr<std::vector<IslandView>> MapStore::GlobalMapView(
    absl::string_view mission_name) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->WithState([](const MissionState& state) {
    std::vector<IslandView> views;
    for (const Island* island : map_store::OrderedIslands(state)) {
      views.push_back(map_store::DescribeIsland(state, *island));
    }
    return views;
  });
}

absl::StatusOr<std::optional<MapChanges>> MapStore::NextChanges(absl::string_view mission_name,
                                                                size_t max_items,
                                                                MapWatcher& watcher) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->WithState(
      [&](const MissionState& state) { return watcher.Next(state, max_items); });
}

absl::StatusOr<uint64_t> MapStore::AddMapListener(absl::string_view mission_name,
                                                  std::function<void()> listener) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->listeners().AddOfMap(std::move(listener));
}

void MapStore::RemoveMapListener(absl::string_view mission_name, uint64_t token) {
  const std::shared_ptr<Mission> mission = directory_->UseIfLoaded(mission_name);
  if (mission != nullptr) mission->listeners().RemoveOfMap(token);
}

absl::StatusOr<std::vector<MapChanges>> MapStore::ReplayMap(
    absl::string_view mission_name, const ReplayOptions& options,
    const std::function<bool()>& goes_on) const {
  RETURN_IF_ERROR(options.Validate());
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->snapshots().TellPast(options, goes_on);
}

absl::StatusOr<std::optional<MissionEvent>> MapStore::EventAfter(absl::string_view mission_name,
                                                                 uint64_t number) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->events().After(number);
}

absl::StatusOr<uint64_t> MapStore::AddEventListener(absl::string_view mission_name,
                                                    std::function<void()> listener) {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  return mission->events().listeners().AddOfMap(std::move(listener));
}

void MapStore::RemoveEventListener(absl::string_view mission_name, uint64_t token) {
  const std::shared_ptr<Mission> mission = directory_->UseIfLoaded(mission_name);
  if (mission != nullptr) mission->events().listeners().RemoveOfMap(token);
}

}  // namespace corbslam::map_store

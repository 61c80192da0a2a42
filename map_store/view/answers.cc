#include "map_store/view/answers.h"

#include <map>
#include <set>
#include <tuple>

#include "absl/strings/str_cat.h"
#include "map_store/view/island_view.h"
#include "map_store/view/last_pose.h"
#include "map_store/view/memory_estimate.h"
#include "map_store/view/metres.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

size_t CountKeyframes(const MissionState& state) {
  size_t count = 0;
  for (const auto& [id, local_map] : state.local_maps) count += local_map.map.keyframes().size();
  return count;
}

// Counts the points of the local layers, each landmark once.
size_t CountPoints(const MissionState& state) {
  size_t count = 0;
  for (const auto& [id, local_map] : state.local_maps) count += local_map.map.points().size();
  for (const auto& [survivor, members] : state.global.landmarks.sets()) {
    for (const MapPointId& member : members) {
      const LocalMapState* owner = state.FindLocalMap(member.local_map);
      if (owner != nullptr && owner->map.FindPoint(member) != nullptr) --count;
    }
  }
  return count;
}

KeyframeInfo DescribeKeyframe(const MissionState& state, const LocalMapState& local_map,
                              const Keyframe& keyframe, const Similarity3d& camera_from_island) {
  KeyframeInfo info;
  info.id = keyframe.id();
  info.agent = local_map.agent;
  info.camera_from_local = keyframe.camera_from_map;
  info.island = state.global.island_of.at(local_map.id);
  info.camera_from_island = camera_from_island;
  const auto placed = state.global.keyframes.find(info.id);
  info.placed = placed != state.global.keyframes.end();
  info.revision = info.placed ? placed->second.revision : 0;
  info.settled = local_map.IsSettled(info.id);
  info.parent = keyframe.parent;
  info.payload = keyframe.payload;
  info.keypoints = keyframe.keypoints().size();
  info.observed_points = CountObservedPoints(state, local_map, keyframe);
  return info;
}

std::vector<UncomparedPair> ListUncompared(const MissionState& state) {
  std::map<std::pair<LocalMapId, LocalMapId>, UncomparedPair> pairs;
  for (const auto& [ids, count] : state.queries.CountByPair()) pairs[ids].waiting = count;
  for (const auto& [ids, count] : state.failed_queries) pairs[ids].failed = count;
  std::vector<UncomparedPair> listed;
  for (auto& [ids, pair] : pairs) {
    std::tie(pair.query, pair.against) = ids;
    listed.push_back(pair);
  }
  return listed;
}

std::string DefaultNote(const OverlapEntry& entry) {
  if (!entry.note.empty()) return entry.note;
  return entry.state == OverlapState::kWaiting ? "waits for fusing" : "";
}

}  // namespace

absl::Status NoSuchLocalMap(LocalMapId id) {
  return absl::NotFoundError(absl::StrCat("there is no local map ", ToString(id)));
}

MissionInfo DescribeMission(const MissionState& state) {
  MissionInfo info;
  info.name = state.name;
  info.uid = state.uid;
  info.revision = state.global.revision;
  info.agents = state.agents.size();
  for (const auto& [name, agent] : state.agents) info.connected_agents += agent.session != 0;
  info.local_maps = state.local_maps.size();
  info.islands = state.global.islands.size();
  info.keyframes = CountKeyframes(state);
  info.map_points = CountPoints(state);
  info.waiting_queries = state.queries.size();
  info.memory_bytes = EstimateMemory(state);
  info.profile = state.profile;
  return info;
}

AgentInfo DescribeAgent(const MissionState& state, const std::string& name,
                        const AgentState& agent) {
  return {.name = name,
          .connected = agent.session != 0,
          .local_maps = agent.local_maps,
          .localise_only = agent.localise_only,
          .last_pose = FindLastPose(state, agent),
          .report = std::nullopt,
          .report_age = absl::ZeroDuration()};
}

LocalMapInfo DescribeLocalMap(const MissionState& state, const LocalMapState& local_map) {
  LocalMapInfo info;
  info.id = local_map.id;
  info.agent = local_map.agent;
  info.number = state.arrivals.NumberOfAgent(local_map.id);
  info.island = state.global.island_of.at(local_map.id);
  info.in_reference_island = info.island == state.ReferenceIsland();
  info.in_metres = local_map.cameras.empty() || IsInMetres(local_map);
  info.island_in_metres =
      local_map.cameras.empty() || IsInMetres(state, state.global.islands.at(info.island));
  info.closed = local_map.closed;
  info.last_batch = local_map.last_batch;
  info.keyframes = local_map.map.keyframes().size();
  for (const auto& [id, keyframe] : local_map.map.keyframes()) {
    if (local_map.IsSettled(id)) ++info.settled_keyframes;
    if (state.global.keyframes.contains(id)) ++info.placed_keyframes;
  }
  info.map_points = local_map.map.points().size();
  info.tracked_frames = local_map.frames.size();
  info.lost_frames = local_map.lost_frames_ns.size();
  info.parked_references = local_map.CountParked();
  info.retired_keyframes = local_map.retired_keyframes;
  for (const JoinedLocalMap& part : local_map.joined) {
    info.joined.push_back(part.id);
    info.joined_numbers.push_back(state.arrivals.NumberOfAgent(part.id));
  }
  info.faded_points = local_map.faded_points;
  return info;
}

std::vector<KeyframeInfo> DescribeKeyframes(const MissionState& state,
                                            const std::vector<KeyframeId>& ids) {
  const Unplaced none;
  PoseCache poses(state, none);
  std::vector<KeyframeInfo> keyframes;
  for (const KeyframeId& id : ids) {
    const LocalMapState& local_map = *state.FindLocalMap(id.local_map);
    keyframes.push_back(DescribeKeyframe(state, local_map, *local_map.map.FindKeyframe(id),
                                         poses.Of(local_map).at(id)));
  }
  return keyframes;
}

MissionStatistics DescribeStatistics(const MissionState& state) {
  MissionStatistics statistics = state.statistics;
  statistics.revision = state.global.revision;
  statistics.islands = state.global.islands.size();
  statistics.keyframes = CountKeyframes(state);
  statistics.map_points = CountPoints(state);
  statistics.uncompared = ListUncompared(state);
  return statistics;
}

OverlapInfo DescribeOverlap(const MissionState& state, const OverlapEntry& entry) {
  OverlapInfo info;
  info.id = entry.id;
  info.overlap = entry.overlap;
  const Island* a = state.FindIslandOf(entry.overlap.query.local_map);
  const Island* b = state.FindIslandOf(entry.overlap.candidate.local_map);
  info.fused = a != nullptr && a == b;
  info.revision = entry.revision;
  info.note = DefaultNote(entry);
  return info;
}

bool Matches(const OverlapFilter& filter, const Overlap& overlap, const MissionState& state) {
  if (filter.accepted.has_value() && *filter.accepted != overlap.IsAccepted()) return false;
  if (!filter.local_map.IsValid()) return true;
  const LocalMapId wanted = state.OwnerOf(filter.local_map);
  return state.OwnerOf(overlap.query.local_map) == wanted ||
         state.OwnerOf(overlap.candidate.local_map) == wanted;
}

IslandView DescribeIsland(const MissionState& state, const Island& island) {
  IslandView view;
  view.id = island.id;
  view.is_reference = island.id == state.ReferenceIsland();
  view.local_maps = island.local_maps;
  const Unplaced none;
  PoseCache poses(state, none);
  std::map<MapPointId, uint32_t> observations;
  for (const LocalMapId& id :
       std::set<LocalMapId>(island.local_maps.begin(), island.local_maps.end())) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      view.keyframes.push_back({keyframe_id, keyframe.payload->timestamp_ns,
                                poses.Of(local_map).at(keyframe_id).ToRigid(), keyframe.parent,
                                state.global.keyframes.contains(keyframe_id)});
      for (const MapPointId& point : ObservedPoints(state, local_map, keyframe)) {
        if (point.IsValid()) ++observations[point];
      }
    }
  }
  for (const auto& [id, count] : observations) {
    const LocalMapState& owner = *state.FindLocalMap(id.local_map);
    view.points.push_back(
        {id, ComputePosition(*owner.map.FindPoint(id), owner, state.global, poses.Of(owner)),
         count});
  }
  return view;
}

std::vector<const Island*> OrderedIslands(const MissionState& state) {
  std::vector<const Island*> islands;
  const IslandId reference = state.ReferenceIsland();
  for (const auto& [id, island] : state.global.islands) {
    if (id == reference) {
      islands.insert(islands.begin(), &island);
    } else {
      islands.push_back(&island);
    }
  }
  return islands;
}

}  // namespace corbslam::map_store

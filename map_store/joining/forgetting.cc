#include "map_store/joining/forgetting.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "absl/container/btree_map.h"
#include "absl/strings/str_cat.h"
#include "map_store/ingest/anchoring.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

int64_t NewestTime(const LocalMapState& local_map) {
  int64_t newest = local_map.newest_lost_ns;
  for (const JoinedLocalMap& part : local_map.joined) {
    newest = std::max(newest, part.newest_lost_ns);
  }
  for (const TrackedFrame& frame : local_map.frames) newest = std::max(newest, frame.timestamp_ns);
  for (const auto& [id, keyframe] : local_map.map.keyframes()) {
    newest = std::max(newest, keyframe.payload->timestamp_ns);
  }
  return newest;
}

void Count(const LocalMapState& local_map, const ArrivalBook& arrivals,
           ForgottenLocalMaps& forgotten) {
  forgotten.local_maps.push_back(local_map.id);
  for (const LocalMapId& name : local_map.Names()) {
    forgotten.numbers.push_back(arrivals.NumberOfAgent(name));
  }
  forgotten.keyframes += local_map.map.keyframes().size();
  forgotten.map_points += local_map.map.points().size();
  forgotten.stored_bytes += local_map.stored_bytes;
  forgotten.parts += local_map.joined.size();
}

// Landmarks elect others in the place of the points, which take over where they are. Nothing is
// taken out of the local map's own graph, which goes as a whole.
void HandOverPoints(const LocalMapState& local_map, MissionState& state) {
  for (const auto& [id, point] : local_map.map.points()) {
    const MapPointId elected = state.global.landmarks.Remove(id);
    HandOverPlace(id, elected, state);
    if (elected.IsValid()) state.global.heirs[id] = elected;
  }
}

void ForgetKeyframes(const LocalMapState& local_map, GlobalLayer& global) {
  for (const auto& [id, keyframe] : local_map.map.keyframes()) {
    global.keyframes.erase(id);
    global.culled.erase(id);
    const RejectedOf rejected(id, global.rejected);
    global.rejected.erase(rejected.begin(), rejected.end());
  }
}

// Forgets what fusion still knows of the names: nothing of these is there any more.
void ForgetTraces(const std::set<LocalMapId>& names, MissionState& state) {
  GlobalLayer& global = state.global;
  const auto is_of_them = [&names](const auto& id) { return names.contains(id.local_map); };
  std::erase_if(global.stand_ins, [&](const auto& item) {
    return is_of_them(item.first) || is_of_them(item.second.keyframe);
  });
  std::vector<MapPointId> childless;
  for (const auto& [id, heir] : global.heirs) {
    if (!ResolvePoint(state, heir).IsValid()) childless.push_back(id);
  }
  for (const MapPointId& id : childless) global.heirs.erase(id);
  std::erase_if(global.taken_back, [&](const auto& pair) {
    return is_of_them(pair.first) || is_of_them(pair.second);
  });
  std::erase_if(global.kept_apart, [&](const auto& pair) {
    return names.contains(pair.first) || names.contains(pair.second);
  });
  std::erase_if(state.failed_queries, [&](const auto& item) {
    return names.contains(item.first.first) || names.contains(item.first.second);
  });
  std::vector<QueryTask> tasks = state.queries.ToTasks();
  std::erase_if(tasks, [&](const QueryTask& task) {
    return is_of_them(task.query) || names.contains(task.against);
  });
  state.queries = QueryQueue(tasks);
}

void ForgetOverlaps(const std::set<LocalMapId>& names, MissionState& state) {
  OverlapLedger::Entries entries = state.global.overlaps.entries();
  std::erase_if(entries, [&names](const auto& item) {
    const Overlap& overlap = item.second.overlap;
    return names.contains(overlap.query.local_map) || names.contains(overlap.candidate.local_map);
  });
  state.global.overlaps = OverlapLedger(std::move(entries));
}

void LeaveIsland(const LocalMapState& local_map, MissionState& state) {
  Island& island = *state.FindIslandOf(local_map.id);
  const auto is_of_it = [&](KeyframeId id) { return local_map.IsNamed(id.local_map); };
  std::erase(island.local_maps, local_map.id);
  std::erase_if(island.displaced, is_of_it);
  std::erase_if(island.moved, is_of_it);
  island.relaxed.erase(local_map.id);
  ++island.generation;
  if (island.local_maps.empty()) state.global.islands.erase(island.id);
  for (const LocalMapId& name : local_map.Names()) state.global.island_of.erase(name);
}

void Drop(LocalMapId id, MissionState& state) {
  const LocalMapState& local_map = state.local_maps.at(id);
  LeaveIsland(local_map, state);
  state.forgotten[id] = local_map.last_batch;
  for (const JoinedLocalMap& part : local_map.joined) {
    state.forgotten[part.id] = part.last_batch;
    state.joined_into.erase(part.id);
  }
  std::erase(state.agents.at(local_map.agent).local_maps, id);
  std::erase(state.order, id);
  state.global.island_from_local.erase(id);
  state.poses.Add(id, nullptr);
  state.local_maps.erase(id);
}

// The global frame stays that of the reference island, as long as there is something in it.
void KeepReference(IslandId reference, MissionState& state) {
  const auto first = std::ranges::find_if(
      state.order, [&](LocalMapId id) { return state.global.island_of.at(id) == reference; });
  if (first != state.order.end()) std::rotate(state.order.begin(), first, first + 1);
  for (size_t i = 0; i < state.order.size(); ++i) state.local_maps.at(state.order[i]).order = i;
}

// Others' keyframes see nothing any more where they saw what has gone and has no heir.
void ForgetSights(const std::set<LocalMapId>& names, MissionState& state) {
  for (auto& [id, local_map] : state.local_maps) {
    for (auto it = local_map.foreign_observations.begin();
         it != local_map.foreign_observations.end();) {
      absl::erase_if(it->second, [&](const auto& seen) {
        return names.contains(seen.second.local_map) && !state.global.heirs.contains(seen.second);
      });
      it = it->second.empty() ? local_map.foreign_observations.erase(it) : std::next(it);
    }
    std::erase_if(local_map.foreign_loop_edges,
                  [&](const LoopEdge& edge) { return names.contains(edge.b.local_map); });
  }
}

}  // namespace

absl::StatusOr<ForgottenLocalMaps> ChooseForgotten(const ForgetRequest& request,
                                                   const MissionState& state) {
  if (request.before_ns.has_value() == request.keep.has_value()) {
    return absl::InvalidArgumentError(
        "say either before which time, or how many of the newest local maps are kept");
  }
  const auto agent = state.agents.find(request.agent);
  if (agent == state.agents.end()) {
    return absl::NotFoundError(
        absl::StrCat("mission ", state.name, " has no agent ", request.agent));
  }
  std::vector<const LocalMapState*> closed;
  for (const LocalMapId& id : agent->second.local_maps) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    if (local_map.closed) closed.push_back(&local_map);
  }
  if (request.keep.has_value())
    closed.resize(closed.size() - std::min(closed.size(), *request.keep));
  ForgottenLocalMaps forgotten;
  for (const LocalMapState* local_map : closed) {
    const bool goes = !request.before_ns.has_value() || NewestTime(*local_map) < *request.before_ns;
    if (goes) Count(*local_map, state.arrivals, forgotten);
  }
  std::ranges::sort(forgotten.numbers);
  return forgotten;
}

absl::Status CheckForgetting(const std::vector<LocalMapId>& local_maps, const MissionState& state) {
  std::set<LocalMapId> named;
  for (const LocalMapId& id : local_maps) {
    const auto it = state.local_maps.find(id);
    const bool sound = it != state.local_maps.end() && it->second.closed && named.insert(id).second;
    if (sound) continue;
    return absl::DataLossError(
        absl::StrCat("a deletion of local map ", ToString(id), ", which is not a closed one"));
  }
  return absl::OkStatus();
}

void ForgetLocalMaps(const std::vector<LocalMapId>& local_maps, MissionState& state) {
  const IslandId reference = state.ReferenceIsland();
  std::set<LocalMapId> names;
  std::set<IslandId> islands;
  for (const LocalMapId& id : local_maps) {
    const LocalMapState& local_map = state.local_maps.at(id);
    const std::vector<LocalMapId> parts = local_map.Names();
    names.insert(parts.begin(), parts.end());
    islands.insert(state.global.island_of.at(id));
    HandOverPoints(local_map, state);
    ForgetKeyframes(local_map, state.global);
  }
  for (const LocalMapId& id : local_maps) Drop(id, state);
  KeepReference(reference, state);
  ForgetTraces(names, state);
  ForgetOverlaps(names, state);
  ForgetSights(names, state);
  IndexPoints(state);
  ++state.global.revision;
  for (const IslandId& id : islands) {
    if (!state.global.islands.contains(id)) continue;
    TouchByFusion(state, id);
    for (const LocalMapId& left : state.global.islands.at(id).local_maps) {
      ForgetChanges(state, state.local_maps.at(left));
    }
  }
  ++state.version;
}

}  // namespace corbslam::map_store

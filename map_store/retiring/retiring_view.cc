#include "map_store/retiring/retiring_view.h"

#include <algorithm>
#include <functional>

#include "map_store/view/island_view.h"
#include "map_store/view/placement.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Who sees what one keyframe sees takes a millisecond or two.
constexpr size_t kKeyframesInAPiece = 1;

std::vector<MapPointId> MembersOf(const MissionState& state, MapPointId landmark) {
  std::vector<MapPointId> members = {landmark};
  const auto it = state.global.landmarks.sets().find(landmark);
  if (it == state.global.landmarks.sets().end()) return members;
  members.insert(members.end(), it->second.begin(), it->second.end());
  return members;
}

std::set<MapPointId> LandmarksOf(const MissionState& state, KeyframeId id) {
  std::set<MapPointId> landmarks;
  const LocalMapState* local_map = state.FindLocalMap(id.local_map);
  const Keyframe* keyframe = local_map == nullptr ? nullptr : local_map->map.FindKeyframe(id);
  if (keyframe == nullptr) return landmarks;
  for (const MapPointId& point : ObservedPoints(state, *local_map, *keyframe)) {
    if (point.IsValid()) landmarks.insert(point);
  }
  return landmarks;
}

size_t CountKeyframes(const Map& map, LocalMapId id) {
  const auto& keyframes = map.keyframes();
  const KeyframeId first{id, 0};
  size_t count = 0;
  for (auto it = keyframes.lower_bound(first); it != keyframes.end(); ++it, ++count) {
    if (it->first.local_map != id) break;
  }
  return count;
}

class ViewTaker {
 public:
  ViewTaker(const MissionState& state, LongRead& read, RetiringView& view)
      : state_(state), read_(read), steps_(read, kKeyframesInAPiece), view_(view) {}

  absl::Status ChooseCandidates(const std::set<KeyframeId>& named, const RetiringReach& reach) {
    absl::flat_hash_map<KeyframeId, int> shared;
    for (const KeyframeId& id : named) {
      RETURN_IF_ERROR(steps_.Advance());
      if (!IsClosed(id)) continue;
      view_.candidates.insert(id);
      for (const MapPointId& landmark : LandmarksOf(state_, id)) {
        for (const KeyframeId& viewer : ViewersOf(state_, landmark)) ++shared[viewer];
      }
    }
    std::vector<std::pair<int, KeyframeId>> ranked;
    for (const auto& [id, count] : shared) {
      if (count >= reach.min_shared && IsClosed(id)) ranked.emplace_back(-count, id);
    }
    std::sort(ranked.begin(), ranked.end());
    for (const auto& [count, id] : ranked) {
      if (view_.candidates.size() >= reach.max_candidates) break;
      view_.candidates.insert(id);
    }
    return absl::OkStatus();
  }

  absl::Status TakeMap() {
    std::set<KeyframeId> keyframes = view_.candidates;
    for (const KeyframeId& id : view_.candidates) {
      RETURN_IF_ERROR(steps_.Advance());
      for (const MapPointId& landmark : LandmarksOf(state_, id)) {
        const auto [it, added] = view_.landmarks.try_emplace(landmark);
        if (!added) continue;
        it->second = MembersOf(state_, landmark);
        for (const KeyframeId& viewer : ViewersOf(state_, landmark)) keyframes.insert(viewer);
      }
    }
    ASSIGN_OR_RETURN(view_.map, BuildPartialView(state_, keyframes, read_));
    return TakePoses();
  }

 private:
  bool IsClosed(KeyframeId id) const {
    return view_.closed.contains(id.local_map) && state_.FindKeyframe(id) != nullptr;
  }

  absl::Status TakePoses() {
    const Unplaced none;
    PoseCache poses(state_, none);
    for (const auto& [id, keyframe] : view_.map.keyframes()) {
      const LocalMapState& local_map = *state_.FindLocalMap(id.local_map);
      const Keyframe* from = local_map.map.FindKeyframe(id);
      if (from == nullptr) return absl::AbortedError("a keyframe of the view has gone");
      view_.poses.emplace_hint(view_.poses.end(), id, poses.Of(local_map).at(id));
      view_.local_poses[id] = from->camera_from_map;
      const Keyframe* parent = local_map.map.FindKeyframe(from->parent);
      if (parent == nullptr) continue;
      view_.parents[id] = parent->id();
      view_.local_poses[parent->id()] = parent->camera_from_map;
    }
    return absl::OkStatus();
  }

  const MissionState& state_;
  LongRead& read_;
  StepsInPieces steps_;
  RetiringView& view_;
};

void ListOverlaps(const MissionState& state, const Island& island, RetiringView& view) {
  for (const uint64_t id : state.global.overlaps.in_graph()) {
    const Overlap& overlap = state.global.overlaps.at(id).overlap;
    const bool joins = overlap.query.local_map != overlap.candidate.local_map &&
                       state.FindIslandOf(overlap.query.local_map) == &island &&
                       state.FindIslandOf(overlap.candidate.local_map) == &island;
    if (!joins || state.FindKeyframe(overlap.query) == nullptr) continue;
    if (state.FindKeyframe(overlap.candidate) == nullptr) continue;
    view.overlaps.emplace_back(overlap.query, overlap.candidate);
  }
}

}  // namespace

std::vector<KeyframeId> ViewersOf(const MissionState& state, MapPointId landmark) {
  std::vector<KeyframeId> viewers;
  for (const MapPointId& member : MembersOf(state, landmark)) {
    const MapPoint* point = state.FindPoint(member);
    if (point == nullptr) continue;
    for (const auto& [keyframe, keypoint] : point->observations) viewers.push_back(keyframe);
    for (const MapPointId& name : state.points.NamesOf(member)) {
      const std::vector<KeyframeId> foreign = state.points.ViewersOf(name);
      if (foreign.empty() || ResolvePoint(state, name) != landmark) continue;
      viewers.insert(viewers.end(), foreign.begin(), foreign.end());
    }
  }
  std::sort(viewers.begin(), viewers.end());
  viewers.erase(std::unique(viewers.begin(), viewers.end()), viewers.end());
  return viewers;
}

absl::StatusOr<RetiringView> TakeRetiringView(const MissionState& state, const Island& island,
                                              const std::set<KeyframeId>& named,
                                              const RetiringReach& reach, LongRead& read) {
  RetiringView view;
  view.island = island.id;
  view.revision = state.global.revision;
  for (const LocalMapId& id : island.local_maps) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    // What has become a part of an earlier local map is a session of its own, as it was; others'
    // may have come between.
    for (const LocalMapId& name : local_map.Names()) {
      if (!local_map.closed) continue;
      view.closed[name] = {id, state.arrivals.NumberOf(name), local_map.last_batch,
                           CountKeyframes(local_map.map, name)};
    }
  }
  ListOverlaps(state, island, view);
  ViewTaker taker(state, read, view);
  RETURN_IF_ERROR(taker.ChooseCandidates(named, reach));
  RETURN_IF_ERROR(taker.TakeMap());
  return view;
}

bool IsStillTrue(const RetiringView& view, const std::vector<MapPointId>& faded,
                 const MissionState& state) {
  if (state.global.revision != view.revision) return false;
  for (const auto& [id, session] : view.closed) {
    const LocalMapState* local_map = state.FindLocalMap(id);
    if (local_map == nullptr || local_map->last_batch != session.last_batch) return false;
  }
  return std::ranges::all_of(faded, [&](MapPointId point) {
    const MapPointId landmark = ResolvePoint(state, point);
    const std::vector<KeyframeId> viewers = ViewersOf(state, landmark);
    return std::ranges::all_of(
        viewers, [&](KeyframeId viewer) { return view.closed.contains(viewer.local_map); });
  });
}

}  // namespace corbslam::map_store

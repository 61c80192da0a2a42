#include "map_store/view/island_view.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "map_store/view/island_covisibility.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// The steps of a piece, after which writers have their turn: 2 to 4 ms. What 2,000 keypoints of a
// keyframe see is an eighth of that.
constexpr size_t kStepsInAPiece = 8000;
constexpr size_t kStepsOfSights = 1000;
constexpr size_t kStepsOfKeyframe = 12;
constexpr size_t kStepsOfEdges = 8;

// Builds a Map of an island's keyframes and what they see.
class ViewBuilder {
 public:
  ViewBuilder(const MissionState& state, const Unplaced& unplaced, Rejected rejected,
              Covisibility covisibility, LongRead& read)
      : state_(state),
        unplaced_(unplaced),
        rejected_(rejected),
        steps_(read, kStepsInAPiece),
        poses_(state, unplaced),
        anchors_(state.global),
        view_(covisibility) {}

  void AddKeyframe(const LocalMapState& local_map, const Keyframe& from) {
    Keyframe keyframe;
    keyframe.payload = from.payload;
    keyframe.words = from.words;
    keyframe.camera_from_map = PosesOf(local_map).at(from.id()).ToRigid();
    keyframe.parent = from.parent;
    view_.AddKeyframe(std::move(keyframe));
  }

  // Adds parents and loop edges. The caller has added all keyframes; owners may have removed some
  // of them since, or added others.
  absl::Status AddEdges() {
    std::set<LocalMapId> local_maps;
    for (const KeyframeId& id : KeyframeIds()) {
      RETURN_IF_ERROR(PauseAtTimes(kStepsOfEdges));
      local_maps.insert(id.local_map);
      const Keyframe* from = state_.FindKeyframe(id);
      if (from == nullptr) continue;
      const KeyframeId parent = AncestorOf(*from);
      if (parent != view_.FindKeyframe(id)->parent) view_.SetParent(id, parent);
      for (const KeyframeId& other : from->loop_edges) view_.AddLoopEdge(id, other);
    }
    for (const LocalMapId& id : local_maps) {
      for (const LoopEdge& edge : state_.FindLocalMap(id)->foreign_loop_edges) {
        view_.AddLoopEdge(edge.a, edge.b);
      }
    }
    return absl::OkStatus();
  }

  // Adds covisibility as owners counted it, under the same conditions as AddEdges.
  absl::Status AddOwnersCovisibility() {
    for (const KeyframeId& id : KeyframeIds()) {
      RETURN_IF_ERROR(PauseAtTimes(kStepsOfEdges));
      const Keyframe* from = state_.FindKeyframe(id);
      if (from == nullptr) continue;
      for (const auto& [other, weight] : from->covisible) {
        if (id < other && IsInView(other)) view_.SetCovisibility(id, other, weight);
      }
    }
    return absl::OkStatus();
  }

  // Adds all that the view's keyframes see.
  absl::Status AddSights() {
    for (const KeyframeId& id : KeyframeIds()) {
      RETURN_IF_ERROR(AddSightsOf(id, /*only_known=*/false));
    }
    return absl::OkStatus();
  }

  // Adds what the neighbourhoods of the centres see, and who else sees it. The view must have its
  // covisibility.
  absl::Status AddSightsAround(const std::set<KeyframeId>& centres, int neighbourhood) {
    std::set<KeyframeId> inner;
    for (const KeyframeId& id : centres) InsertNeighbours(id, neighbourhood, inner);
    std::set<KeyframeId> outer;
    for (const KeyframeId& id : inner) {
      RETURN_IF_ERROR(AddSightsOf(id, /*only_known=*/false));
      InsertNeighbours(id, std::numeric_limits<int>::max(), outer);
    }
    for (const KeyframeId& id : outer) {
      if (!inner.contains(id)) RETURN_IF_ERROR(AddSightsOf(id, /*only_known=*/true));
    }
    return absl::OkStatus();
  }

  // Sets the covisibility of pairs whose keyframes the view has.
  absl::Status SetCovisibility(const std::vector<CovisiblePair>& pairs) {
    // Owners may have moved keyframes while the pairs were counted in pieces.
    ForgetPoses();
    for (const CovisiblePair& pair : pairs) {
      RETURN_IF_ERROR(PauseAtTimes(1));
      if (IsInView(pair.a) && IsInView(pair.b)) {
        view_.SetCovisibility(pair.a, pair.b, pair.weight);
      }
    }
    return absl::OkStatus();
  }

  // Adds the point unless the view has it.
  void AddPoint(MapPointId id) {
    if (view_.FindPoint(id) != nullptr) return;
    const LocalMapState& owner = *state_.FindLocalMap(id.local_map);
    const MapPoint& from = *owner.map.FindPoint(id);
    const Similarity3d& island_from_local = IslandFromLocalAt(from.reference, owner);
    MapPoint point;
    point.id = id;
    point.position_in_map = ComputePosition(from, owner, anchors_, PosesOf(owner), unplaced_);
    point.reference = from.reference;
    point.descriptor = from.descriptor;
    point.normal_in_map = island_from_local.rotation * from.normal_in_map;
    point.min_distance = from.min_distance * island_from_local.scale;
    point.max_distance = from.max_distance * island_from_local.scale;
    view_.AddPoint(std::move(point));
  }

  // The caller calls this after so many steps. Returns ABORTED as the read does.
  absl::Status PauseAtTimes(size_t steps) {
    const uint64_t version = state_.version;
    RETURN_IF_ERROR(steps_.Advance(steps));
    // Owners may have moved, added or removed keyframes in the pause.
    if (state_.version != version) ForgetPoses();
    return absl::OkStatus();
  }

  Map TakeView() { return std::move(view_); }
  const IslandPoses& PosesOf(const LocalMapState& local_map) { return poses_.Of(local_map); }

 private:
  std::vector<KeyframeId> KeyframeIds() const {
    std::vector<KeyframeId> ids;
    ids.reserve(view_.keyframes().size());
    for (const auto& [id, keyframe] : view_.keyframes()) ids.push_back(id);
    return ids;
  }

  // Returns the nearest ancestor that was not culled from the view.
  KeyframeId AncestorOf(const Keyframe& keyframe) const {
    KeyframeId id = keyframe.parent;
    while (state_.global.culled.contains(id) && view_.FindKeyframe(id) == nullptr) {
      const Keyframe* culled = state_.FindKeyframe(id);
      id = culled == nullptr ? KeyframeId() : culled->parent;
    }
    return id;
  }

  void InsertNeighbours(KeyframeId centre, int count, std::set<KeyframeId>& ids) const {
    if (view_.FindKeyframe(centre) == nullptr) return;
    ids.insert(centre);
    for (const CovisibleKeyframe& near : view_.BestCovisible(centre, count)) ids.insert(near.id);
  }

  // The motion is the same for all points of a reference keyframe.
  const Similarity3d& IslandFromLocalAt(KeyframeId reference, const LocalMapState& local_map) {
    const auto [it, added] = motions_.try_emplace(reference);
    if (added) {
      it->second = IslandFromLocal(reference, local_map, state_.global, PosesOf(local_map));
    }
    return it->second;
  }

  void ForgetPoses() {
    poses_.Clear();
    anchors_.Clear();
    motions_.clear();
  }

  bool IsInView(KeyframeId id) const { return view_.FindKeyframe(id) != nullptr; }

  absl::Status AddSightsOf(KeyframeId id, bool only_known) {
    RETURN_IF_ERROR(PauseAtTimes(kStepsOfSights));
    const LocalMapState& local_map = *state_.FindLocalMap(id.local_map);
    const Keyframe* from = local_map.map.FindKeyframe(id);
    // The owner removed it during a pause.
    if (from == nullptr) return absl::OkStatus();
    const std::vector<MapPointId> points = ObservedPoints(state_, local_map, *from, rejected_);
    if (!only_known) {
      for (const MapPointId& point : points) {
        if (point.IsValid()) AddPoint(point);
      }
    }
    view_.AddObservations(id, points);
    return absl::OkStatus();
  }

  const MissionState& state_;
  const Unplaced& unplaced_;
  const Rejected rejected_;
  StepsInPieces steps_;
  PoseCache poses_;
  AnchorCache anchors_;
  absl::flat_hash_map<KeyframeId, Similarity3d> motions_;
  Map view_;
};

enum class Culled { kLeaveOut, kTakeAlong };

// Begins a snapshot: with its keyframes and edges.
absl::StatusOr<IslandSnapshot> BeginSnapshot(const MissionState& state, const Island& island,
                                             Culled culled, ViewBuilder& builder) {
  IslandSnapshot snapshot;
  snapshot.island = island.id;
  snapshot.revision = state.global.revision;
  snapshot.generation = island.generation;
  snapshot.version_of_owners = island.version_of_owners;
  for (const LocalMapId& id : island.local_maps) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    const auto& keyframes = local_map.map.keyframes();
    for (KeyframeId next = {LocalMapId{0}, 0};;) {
      // Keyframes may have come and gone in the pause before.
      const auto it = keyframes.lower_bound(next);
      if (it == keyframes.end()) break;
      const auto& [keyframe_id, keyframe] = *it;
      snapshot.poses.emplace_hint(snapshot.poses.end(), keyframe_id,
                                  builder.PosesOf(local_map).at(keyframe_id));
      snapshot.local_poses.emplace_hint(snapshot.local_poses.end(), keyframe_id,
                                        keyframe.camera_from_map);
      const bool left_out =
          culled == Culled::kLeaveOut && state.global.culled.contains(keyframe_id);
      if (!left_out) builder.AddKeyframe(local_map, keyframe);
      next = {keyframe_id.local_map, keyframe_id.index + 1};
      RETURN_IF_ERROR(builder.PauseAtTimes(kStepsOfKeyframe));
    }
  }
  RETURN_IF_ERROR(builder.AddEdges());
  return snapshot;
}

// Returns the name by which another local map's point goes now; invalid if it is not in this
// island.
MapPointId ResolveWithin(IslandId island, const MissionState& state, MapPointId raw) {
  const MapPointId point = ResolvePoint(state, raw);
  const bool here = point.IsValid() && state.global.island_of.at(point.local_map) == island;
  return here ? point : MapPointId();
}

}  // namespace

std::vector<MapPointId> ObservedPoints(const MissionState& state, const LocalMapState& local_map,
                                       const Keyframe& keyframe, Rejected treatment) {
  const IslandId island = state.global.island_of.at(local_map.id);
  // The points in the local map's own graph are alive: only fusion can have given them other names.
  std::vector<MapPointId> points = keyframe.points;
  for (MapPointId& point : points) {
    if (point.IsValid()) point = state.global.landmarks.Survivor(point);
  }
  const auto foreign = local_map.foreign_observations.find(keyframe.id());
  if (foreign != local_map.foreign_observations.end()) {
    for (const auto& [keypoint, raw] : foreign->second) {
      points[keypoint] = ResolveWithin(island, state, raw);
    }
  }
  if (treatment == Rejected::kTryAgain) return points;
  for (const auto& [sight, raw] : RejectedOf(keyframe.id(), state.global.rejected)) {
    const uint32_t keypoint = sight.second;
    if (RawObservation(local_map, keyframe.id(), keypoint) == raw) points[keypoint] = MapPointId();
  }
  return points;
}

size_t CountObservedPoints(const MissionState& state, const LocalMapState& local_map,
                           const Keyframe& keyframe) {
  const IslandId island = state.global.island_of.at(local_map.id);
  const auto foreign = local_map.foreign_observations.find(keyframe.id());
  const bool sees_foreign = foreign != local_map.foreign_observations.end();
  const auto sees_own = [&](uint32_t keypoint) { return keyframe.points[keypoint].IsValid(); };
  const auto sees_any = [&](uint32_t keypoint) {
    if (!sees_foreign) return sees_own(keypoint);
    const auto it = foreign->second.find(keypoint);
    if (it == foreign->second.end()) return sees_own(keypoint);
    return ResolveWithin(island, state, it->second).IsValid();
  };
  auto count = static_cast<size_t>(std::count_if(keyframe.points.begin(), keyframe.points.end(),
                                                 [](MapPointId id) { return id.IsValid(); }));
  if (sees_foreign) {
    for (const auto& [keypoint, raw] : foreign->second) {
      if (sees_own(keypoint)) --count;
      if (sees_any(keypoint)) ++count;
    }
  }
  for (const auto& [sight, raw] : RejectedOf(keyframe.id(), state.global.rejected)) {
    const uint32_t keypoint = sight.second;
    const bool holds = RawObservation(local_map, keyframe.id(), keypoint) == raw;
    if (holds && sees_any(keypoint)) --count;
  }
  return count;
}

absl::StatusOr<IslandSnapshot> TakeWholeSnapshot(const MissionState& state, const Island& island,
                                                 Unplaced unplaced, Rejected rejected,
                                                 LongRead& read) {
  ViewBuilder builder(state, unplaced, rejected, Covisibility::kGiven, read);
  ASSIGN_OR_RETURN(IslandSnapshot snapshot,
                   BeginSnapshot(state, island, Culled::kLeaveOut, builder));
  RETURN_IF_ERROR(builder.AddSights());
  snapshot.view = builder.TakeView();
  snapshot.unplaced = std::move(unplaced);
  return snapshot;
}

absl::StatusOr<IslandSnapshot> TakeGraphSnapshot(const MissionState& state, const Island& island,
                                                 Unplaced unplaced,
                                                 const std::set<KeyframeId>& centres,
                                                 int neighbourhood,
                                                 const std::set<MapPointId>& named,
                                                 LongRead& read) {
  ViewBuilder builder(state, unplaced, Rejected::kLeaveOut, Covisibility::kGiven, read);
  // Culled keyframes are taken along: without them the spanning tree would fall apart.
  ASSIGN_OR_RETURN(IslandSnapshot snapshot,
                   BeginSnapshot(state, island, Culled::kTakeAlong, builder));
  ASSIGN_OR_RETURN(const std::vector<CovisiblePair> pairs, CountCovisibility(state, island, read));
  RETURN_IF_ERROR(builder.SetCovisibility(pairs));
  RETURN_IF_ERROR(builder.AddSightsAround(centres, neighbourhood));
  for (const MapPointId& id : named) {
    const bool here =
        state.FindPoint(id) != nullptr && state.global.island_of.at(id.local_map) == island.id;
    if (here) builder.AddPoint(id);
  }
  snapshot.view = builder.TakeView();
  snapshot.unplaced = std::move(unplaced);
  return snapshot;
}

absl::StatusOr<Map> BuildPartialView(const MissionState& state,
                                     const std::set<KeyframeId>& keyframes, LongRead& read) {
  const Unplaced none;
  ViewBuilder builder(state, none, Rejected::kLeaveOut, Covisibility::kGiven, read);
  for (const KeyframeId& id : keyframes) {
    const LocalMapState* local_map = state.FindLocalMap(id.local_map);
    const Keyframe* keyframe = local_map == nullptr ? nullptr : local_map->map.FindKeyframe(id);
    if (keyframe != nullptr) builder.AddKeyframe(*local_map, *keyframe);
  }
  RETURN_IF_ERROR(builder.AddEdges());
  RETURN_IF_ERROR(builder.AddOwnersCovisibility());
  RETURN_IF_ERROR(builder.AddSights());
  return builder.TakeView();
}

}  // namespace corbslam::map_store

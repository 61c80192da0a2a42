#include "map_store/view/placement.h"

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "map_store/view/visible_motion.h"

namespace corbslam::map_store {
namespace {

// Returns the pose by which the keyframe keeps its local pose relative to `relative`.
Similarity3d Follow(const Keyframe& keyframe, const Keyframe& relative,
                    const Similarity3d& relative_from_island) {
  const Rigid3d keyframe_from_relative =
      keyframe.camera_from_map * relative.camera_from_map.Inverse();
  return Similarity3d::FromRigid(keyframe_from_relative) * relative_from_island;
}

// Gives keyframes the pose by their nearest placed relative in the tree. It searches breadth first
// from all placed keyframes at once (those in `front`: the others find nothing); ties go by id.
void SpreadOverTree(const Map& map, std::deque<KeyframeId> front, IslandPoses& poses) {
  while (!front.empty()) {
    const Keyframe& from = *map.FindKeyframe(front.front());
    front.pop_front();
    const auto visit = [&](KeyframeId id) {
      const Keyframe* keyframe = map.FindKeyframe(id);
      if (keyframe == nullptr || poses.contains(id)) return;
      poses[id] = Follow(*keyframe, from, poses.at(from.id()));
      front.push_back(id);
    };
    visit(from.parent);
    for (const KeyframeId& child : from.children) visit(child);
  }
}

void SpreadInOrder(const Map& map, IslandPoses& poses) {
  if (poses.size() == map.keyframes().size()) return;
  const IslandPoses reached = poses;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (reached.contains(id)) continue;
    auto relative = reached.lower_bound(id);
    if (relative != reached.begin()) --relative;
    poses[id] = Follow(keyframe, *map.FindKeyframe(relative->first), relative->second);
  }
}

// Returns the placed keyframes that have a relative without a pose, in the order of their ids.
std::deque<KeyframeId> FindFront(const Map& map, const IslandPoses& poses) {
  std::set<KeyframeId> front;
  auto placed = poses.begin();
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (placed != poses.end() && placed->first == id) {
      ++placed;
      continue;
    }
    if (poses.contains(keyframe.parent)) front.insert(keyframe.parent);
    for (const KeyframeId& child : keyframe.children) {
      if (poses.contains(child)) front.insert(child);
    }
  }
  return {front.begin(), front.end()};
}

// Goes through a table in the order of ids.
class TableWalk {
 public:
  // `table` may be null: then nothing stood anywhere.
  explicit TableWalk(const PoseTable* table) : table_(table) {}

  // Returns how the keyframe stood; null if it did not. Ids rise from call to call.
  const PoseTable::Standing* Find(KeyframeId id) {
    if (table_ == nullptr) return nullptr;
    const std::vector<PoseTable::Standing>& standings = table_->standings;
    while (at_ < standings.size() && standings[at_].id < id) ++at_;
    return at_ == standings.size() || standings[at_].id != id ? nullptr : &standings[at_];
  }

 private:
  const PoseTable* const table_;
  size_t at_ = 0;
};

bool HasAnyOf(const Unplaced& unplaced, LocalMapId local_map) {
  const auto it = unplaced.lower_bound(KeyframeId{local_map, 0});
  return it != unplaced.end() && it->local_map == local_map;
}

// Goes through what is placed in the order of ids; from one name of a local map to the next it
// leaps over all between them.
class PlacedWalk {
 public:
  explicit PlacedWalk(const PlacedKeyframes& placed) : placed_(placed), at_(placed.end()) {}

  // Returns null if the keyframe is not placed. Ids rise from call to call.
  const PlacedKeyframe* Find(KeyframeId id) {
    if (id.local_map != name_) {
      name_ = id.local_map;
      at_ = placed_.lower_bound(id);
    }
    while (at_ != placed_.end() && at_->first < id) ++at_;
    return at_ == placed_.end() || at_->first != id ? nullptr : &at_->second;
  }

 private:
  const PlacedKeyframes& placed_;
  PlacedKeyframes::const_iterator at_;
  LocalMapId name_;
};

// Returns where the point lies by its place relative to its reference keyframe or, if that has no
// pose, to one that sees it.
Eigen::Vector3d FollowReference(const MapPoint& point, KeyframeId reference,
                                const LocalMapState& local_map, const GlobalLayer& global,
                                const IslandPoses& poses) {
  if (!poses.contains(reference) && !point.observations.empty()) {
    reference = point.observations.begin()->first;
  }
  return IslandFromLocal(reference, local_map, global, poses) * point.position_in_map;
}

}  // namespace

IslandPoses ComputePoses(const LocalMapState& local_map, const GlobalLayer& global,
                         const Unplaced& unplaced) {
  const auto last = global.island_from_local.find(local_map.id);
  return ComputePoses(local_map, global.keyframes,
                      last == global.island_from_local.end() ? nullptr : &last->second, unplaced);
}

IslandPoses ComputePoses(const LocalMapState& local_map, const PlacedKeyframes& all_placed,
                         const Similarity3d* last, const Unplaced& unplaced) {
  IslandPoses poses;
  PlacedWalk walk(all_placed);
  for (const auto& [id, keyframe] : local_map.map.keyframes()) {
    const PlacedKeyframe* placed = walk.Find(id);
    if (placed == nullptr || unplaced.contains(id)) continue;
    poses.emplace_hint(poses.end(), id, placed->camera_from_island);
  }
  if (poses.size() == local_map.map.keyframes().size()) return poses;
  if (!poses.empty()) {
    SpreadOverTree(local_map.map, FindFront(local_map.map, poses), poses);
    SpreadInOrder(local_map.map, poses);
    return poses;
  }
  for (const auto& [id, keyframe] : local_map.map.keyframes()) {
    const Similarity3d pose = Similarity3d::FromRigid(keyframe.camera_from_map);
    poses.emplace_hint(poses.end(), id, last == nullptr ? pose : pose * last->Inverse());
  }
  return poses;
}

std::shared_ptr<const PoseTable> FindPoses(const MissionState& state,
                                           const LocalMapState& local_map) {
  const std::shared_ptr<const PoseTable> old = state.poses.Find(local_map.id);
  if (old != nullptr && old->version == local_map.places_version) return old;
  auto table = std::make_shared<PoseTable>();
  table->version = local_map.places_version;
  table->poses = ComputePoses(local_map, state.global);
  table->standings.reserve(table->poses.size());
  TableWalk before(old.get());
  PlacedWalk walk(state.global.keyframes);
  for (const auto& [id, pose] : table->poses) {
    const bool is_placed = walk.Find(id) != nullptr;
    const PoseTable::Standing* stood = before.Find(id);
    const bool stands = stood != nullptr && stood->placed == is_placed &&
                        !IsSeenToMove(stood->shown, pose, local_map.map.FindKeyframe(id)->camera());
    table->standings.push_back(stands ? *stood
                                      : PoseTable::Standing{id, is_placed, table->version, pose});
  }
  state.poses.Add(local_map.id, table);
  return table;
}

const IslandPoses& PoseCache::Of(const LocalMapState& local_map) {
  const auto [it, added] = poses_.try_emplace(local_map.id);
  if (!added) return *it->second;
  const std::vector<LocalMapId> names = local_map.Names();
  if (std::ranges::any_of(names, [&](LocalMapId id) { return HasAnyOf(unplaced_, id); })) {
    it->second =
        std::make_shared<const IslandPoses>(ComputePoses(local_map, state_.global, unplaced_));
  } else {
    const std::shared_ptr<const PoseTable> table = FindPoses(state_, local_map);
    it->second = std::shared_ptr<const IslandPoses>(table, &table->poses);
  }
  return *it->second;
}

Similarity3d IslandFromLocal(KeyframeId reference, const LocalMapState& local_map,
                             const GlobalLayer& global, const IslandPoses& poses) {
  auto it = poses.lower_bound(reference);
  if (it == poses.end() && it != poses.begin()) --it;
  if (it == poses.end()) {
    const auto last = global.island_from_local.find(local_map.id);
    return last == global.island_from_local.end() ? Similarity3d() : last->second;
  }
  const Keyframe& keyframe = *local_map.map.FindKeyframe(it->first);
  return it->second.Inverse() * Similarity3d::FromRigid(keyframe.camera_from_map);
}

Similarity3d IslandFromLocal(const LocalMapState& local_map, const IslandPoses& poses) {
  const auto& [id, pose] = *poses.rbegin();
  return pose.Inverse() * Similarity3d::FromRigid(local_map.map.FindKeyframe(id)->camera_from_map);
}

std::optional<PlacedAnchor> FindPlaced(MapPointId id, const GlobalLayer& global) {
  const auto point = global.points.find(id);
  if (point == global.points.end()) return std::nullopt;
  const auto keyframe = global.keyframes.find(point->second.anchor);
  if (keyframe == global.keyframes.end()) return std::nullopt;
  return PlacedAnchor{&point->second, &keyframe->second};
}

std::optional<PlacedPoint> Anchor(const MapPoint& point, const Eigen::Vector3d& position_in_island,
                                  uint64_t revision, const GlobalLayer& global,
                                  const PlacedKeyframes& placed) {
  auto anchor = placed.find(ReferenceOf(point, global));
  for (auto seen = point.observations.begin();
       anchor == placed.end() && seen != point.observations.end(); ++seen) {
    anchor = placed.find(seen->first);
  }
  if (anchor == placed.end()) return std::nullopt;
  return PlacedPoint{anchor->first, anchor->second.camera_from_island * position_in_island,
                     revision};
}

std::optional<Eigen::Vector3d> AnchorCache::FindPosition(MapPointId id, const Unplaced& unplaced) {
  const auto point = global_.points.find(id);
  if (point == global_.points.end()) return std::nullopt;
  const KeyframeId anchor = point->second.anchor;
  if (unplaced.contains(anchor)) return std::nullopt;
  const auto [it, added] = island_from_anchor_.try_emplace(anchor);
  if (added) {
    const auto placed = global_.keyframes.find(anchor);
    if (placed != global_.keyframes.end()) it->second = placed->second.camera_from_island.Inverse();
  }
  if (!it->second.has_value()) return std::nullopt;
  return *it->second * point->second.position_in_anchor;
}

Eigen::Vector3d ComputePosition(const MapPoint& point, const LocalMapState& local_map,
                                const GlobalLayer& global, const IslandPoses& poses,
                                const Unplaced& unplaced) {
  const KeyframeId reference = ReferenceOf(point, global);
  const std::optional<PlacedAnchor> placed = FindPlaced(point.id, global);
  if (placed.has_value() && !unplaced.contains(reference) &&
      !unplaced.contains(placed->point->anchor)) {
    return placed->PositionInIsland();
  }
  return FollowReference(point, reference, local_map, global, poses);
}

Eigen::Vector3d ComputePosition(const MapPoint& point, const LocalMapState& local_map,
                                AnchorCache& anchors, const IslandPoses& poses,
                                const Unplaced& unplaced) {
  const KeyframeId reference = ReferenceOf(point, anchors.global());
  if (!unplaced.contains(reference)) {
    if (const auto position = anchors.FindPosition(point.id, unplaced)) return *position;
  }
  return FollowReference(point, reference, local_map, anchors.global(), poses);
}

KeyframeId ReferenceOf(const MapPoint& point, const GlobalLayer& global) {
  if (!global.culled.contains(point.reference)) return point.reference;
  for (const auto& [id, keypoint] : point.observations) {
    if (!global.culled.contains(id)) return id;
  }
  return point.reference;
}

bool FindLivingRelative(const MissionState& state, KeyframeId id, LivingRelative& found,
                        RelativeIn layer) {
  found = {id, Rigid3d::Identity()};
  // The search is bounded: a hostile owner could name removed keyframes each other's parents.
  for (int step = 0; step < 10000; ++step) {
    const LocalMapState* local_map = state.FindLocalMap(found.id.local_map);
    if (local_map == nullptr) return false;
    if (local_map->map.FindKeyframe(found.id) != nullptr) return true;
    const auto stand_in = state.global.stand_ins.find(found.id);
    if (layer == RelativeIn::kGlobalLayer && stand_in != state.global.stand_ins.end()) {
      found.relative_from_id = stand_in->second.keyframe_from_retired * found.relative_from_id;
      found.id = stand_in->second.keyframe;
      continue;
    }
    const auto tombstone = local_map->removed_keyframes.find(found.id);
    if (tombstone == local_map->removed_keyframes.end()) return false;
    found.relative_from_id = tombstone->second.parent_from_removed * found.relative_from_id;
    found.id = tombstone->second.parent;
  }
  return false;
}

}  // namespace corbslam::map_store

#include "map_store/view/map_watcher.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "map_store/view/answers.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {

namespace {

// For each item of a piece so many points may be looked at.
constexpr size_t kStepsPerItem = 16;

bool HasLocalMap(const Island& island, LocalMapId id) {
  return std::ranges::find(island.local_maps, id) != island.local_maps.end();
}

// Adds the points that follow this reference keyframe, as fusion has not placed them.
void AddFollowers(const MissionState& state, const LocalMapState& local_map, KeyframeId id,
                  std::set<MapPointId>& points) {
  const Keyframe* keyframe = local_map.map.FindKeyframe(id);
  if (keyframe == nullptr) return;
  for (const MapPointId& point : keyframe->points) {
    const bool follows = point.IsValid() && !map_store::FindPlaced(point, state.global).has_value();
    if (follows) points.insert(point);
  }
}

// Returns whether the point is shown: a landmark is shown by its survivor only.
bool IsShown(const MissionState& state, MapPointId id) {
  return state.FindPoint(id) != nullptr && state.global.landmarks.Survivor(id) == id;
}

// Returns how many keyframes see the landmark, of the local maps in which its points were made.
uint32_t CountSights(const MissionState& state, MapPointId survivor, const MapPoint& point) {
  size_t sights = point.observations.size();
  const auto members = state.global.landmarks.sets().find(survivor);
  if (members == state.global.landmarks.sets().end()) return static_cast<uint32_t>(sights);
  for (const MapPointId& member : members->second) {
    const MapPoint* other = state.FindPoint(member);
    if (other != nullptr) sights += other->observations.size();
  }
  return static_cast<uint32_t>(sights);
}

// Returns all names that an island can ever have had, those of local maps included that are parts
// of others or were deleted since.
std::vector<IslandId> EverNamed(const MissionState& state) {
  std::vector<IslandId> names = state.order;
  for (const auto& [part, whole] : state.joined_into) names.push_back(part);
  for (const auto& [deleted, last_batch] : state.forgotten) names.push_back(deleted);
  return names;
}

// Returns the island's part of the piece, which is begun where there is none.
MapChanges::Island& PieceOf(const MissionState& state, IslandId id, MapChanges& changes) {
  for (MapChanges::Island& island : changes.islands) {
    if (island.id == id) return island;
  }
  MapChanges::Island& island = changes.islands.emplace_back();
  island.id = id;
  island.is_reference = id == state.ReferenceIsland();
  island.local_maps = state.global.islands.at(id).local_maps;
  for (const LocalMapId& id_of_map : island.local_maps) {
    const LocalMapState& local_map = *state.FindLocalMap(id_of_map);
    island.agents.push_back(local_map.agent);
    for (const JoinedLocalMap& part : local_map.joined) {
      island.parts.emplace_back(part.id, local_map.agent);
    }
  }
  return island;
}

}  // namespace

bool MapWatcher::CanUpdate(const MissionState& state, const Island& island) const {
  if (!islands_.contains(island.id)) return false;
  for (const auto& [local_map, seen_in] : seen_) {
    if (seen_in == island.id && !HasLocalMap(island, local_map)) return false;
  }
  return std::ranges::all_of(island.local_maps, [&](LocalMapId id) {
    const auto seen = seen_.find(id);
    const bool is_new = seen == seen_.end() || seen->second != island.id;
    return is_new || state.FindLocalMap(id)->changes.Knows(version_);
  });
}

std::optional<MapWatcher::Part> MapWatcher::MakePart(const MissionState& state, LocalMapId id,
                                                     IslandId island, bool anew) const {
  const LocalMapState& local_map = *state.FindLocalMap(id);
  Part part;
  part.local_map = id;
  part.island = island;
  part.next_keyframe = {LocalMapId{0}, 0};
  part.next_point = {LocalMapId{0}, 0};
  part.since = version_;
  const auto seen = seen_.find(id);
  part.whole = anew || seen == seen_.end() || seen->second != island;
  if (part.whole) return part;
  const ItemChanges changes = *local_map.changes.Since(version_);
  if (changes.size() == 0 && local_map.places_version <= version_) return std::nullopt;
  part.keyframes = {changes.keyframes.begin(), changes.keyframes.end()};
  if (!include_points_) return part;
  part.points = {changes.points.begin(), changes.points.end()};
  part.points.insert(changes.landmarks.begin(), changes.landmarks.end());
  part.fusion_moved_points = state.global.revision != revision_;
  return part;
}

void MapWatcher::BeginIsland(const MissionState& state, const Island& island, MapChanges& changes) {
  const bool anew = !CanUpdate(state, island);
  PieceOf(state, island.id, changes).anew = anew;
  for (const LocalMapId& id : island.local_maps) {
    if (auto part = MakePart(state, id, island.id, anew)) parts_.push_back(*std::move(part));
  }
}

void MapWatcher::Begin(const MissionState& state, MapChanges& changes) {
  for (const IslandId& id :
       begun_ ? std::vector<IslandId>(islands_.begin(), islands_.end()) : EverNamed(state)) {
    if (!state.global.islands.contains(id)) changes.removed_islands.push_back(id);
  }
  for (const Island* island : map_store::OrderedIslands(state)) {
    if (island->version > version_) BeginIsland(state, *island, changes);
  }
  begun_ = true;
  islands_.clear();
  seen_.clear();
  for (const auto& [id, island] : state.global.islands) {
    islands_.insert(id);
    for (const LocalMapId& local_map : island.local_maps) seen_[local_map] = id;
  }
  version_of_change_ = state.version;
  revision_of_change_ = state.global.revision;
}

bool MapWatcher::TakeKeyframes(const MissionState& state, Part& part, size_t& room,
                               MapChanges::Island& changes) {
  const LocalMapState& local_map = *state.FindLocalMap(part.local_map);
  const std::shared_ptr<const PoseTable> table = map_store::FindPoses(state, local_map);
  auto pose_of = table->poses.lower_bound(part.next_keyframe);
  const auto begin =
      std::ranges::lower_bound(table->standings, part.next_keyframe, {}, &PoseTable::Standing::id);
  for (auto standing = begin; standing != table->standings.end(); ++standing, ++pose_of) {
    const auto& [id, pose] = *pose_of;
    const bool is_news =
        part.whole || standing->changed_at > part.since || part.keyframes.contains(id);
    if (!is_news) continue;
    if (room == 0) {
      part.next_keyframe = id;
      return false;
    }
    --room;
    const Keyframe& keyframe = *local_map.map.FindKeyframe(id);
    changes.keyframes.push_back(
        {id, keyframe.payload->timestamp_ns, pose.ToRigid(), keyframe.parent, standing->placed});
    if (include_points_ && !part.whole) AddFollowers(state, local_map, id, part.points);
  }
  for (const KeyframeId& id : std::exchange(part.keyframes, {})) {
    if (!table->poses.contains(id)) changes.removed_keyframes.push_back(id);
  }
  constexpr uint64_t kLast = std::numeric_limits<uint64_t>::max();
  part.next_keyframe = {LocalMapId{kLast}, KeyframeId::kNoIndex};
  return true;
}

bool MapWatcher::TakePoints(const MissionState& state, Part& part, size_t& room,
                            MapChanges::Island& changes) {
  if (!include_points_) return true;
  const LocalMapState& local_map = *state.FindLocalMap(part.local_map);
  const std::shared_ptr<const PoseTable> table = map_store::FindPoses(state, local_map);
  const auto take = [&](MapPointId id) {
    --room;
    const MapPoint& point = *local_map.map.FindPoint(id);
    changes.points.push_back(
        {id, map_store::ComputePosition(point, local_map, state.global, table->poses),
         CountSights(state, id, point)});
  };
  while (!part.points.empty()) {
    if (room == 0) return false;
    const MapPointId id = *part.points.begin();
    part.points.erase(part.points.begin());
    if (IsShown(state, id)) {
      take(id);
    } else {
      --room;
      changes.removed_points.push_back(id);
    }
  }
  if (!part.whole && !part.fusion_moved_points) return true;
  const auto& points = local_map.map.points();
  for (auto it = points.lower_bound(part.next_point); it != points.end(); ++it) {
    const MapPointId id = it->first;
    // A look costs far less than telling, but an island may have millions of points of which a few
    // have moved: robots' batches come in between.
    if (room == 0 || steps_ == 0) {
      part.next_point = id;
      room = 0;
      return false;
    }
    --steps_;
    if (!part.whole) {
      const auto placed = map_store::FindPlaced(id, state.global);
      if (!placed.has_value() || placed->revision() <= revision_) continue;
    }
    if (IsShown(state, id)) take(id);
  }
  return true;
}

std::optional<MapChanges> MapWatcher::Next(const MissionState& state, size_t max_items) {
  MapChanges changes;
  // A version newer than the store's is of changes that the store has lost.
  if (version_ > state.version) *this = MapWatcher(0, include_points_);
  if (parts_.empty()) {
    if (state.version == version_) return std::nullopt;
    Begin(state, changes);
  }
  changes.version = version_of_change_;
  changes.revision = revision_of_change_;
  size_t room = std::max<size_t>(max_items, 1);
  steps_ = room * kStepsPerItem;
  while (!parts_.empty() && room > 0) {
    Part& part = parts_.front();
    // If the local map is in another island meanwhile, the next change tells all of it.
    const auto lies = state.global.island_of.find(part.local_map);
    const bool is_here = lies != state.global.island_of.end() && lies->second == part.island;
    const bool done =
        !is_here || (TakeKeyframes(state, part, room, PieceOf(state, part.island, changes)) &&
                     TakePoints(state, part, room, PieceOf(state, part.island, changes)));
    if (done) parts_.pop_front();
  }
  changes.continues = !parts_.empty();
  if (changes.continues) return changes;
  version_ = version_of_change_;
  revision_ = revision_of_change_;
  return changes;
}

}  // namespace corbslam::map_store

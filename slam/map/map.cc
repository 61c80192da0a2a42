#include "slam/map/map.h"

#include <algorithm>
#include <utility>

namespace corbslam {
namespace {

MapObserver& Silent() {
  static MapObserver silent;
  return silent;
}

std::vector<CovisibleKeyframe> SortByWeight(const Keyframe& keyframe, int min_weight) {
  std::vector<CovisibleKeyframe> sorted;
  sorted.reserve(keyframe.covisible.size());
  for (const auto& [id, weight] : keyframe.covisible) {
    if (weight >= min_weight) sorted.push_back({id, weight});
  }
  std::stable_sort(
      sorted.begin(), sorted.end(),
      [](const CovisibleKeyframe& a, const CovisibleKeyframe& b) { return a.weight > b.weight; });
  return sorted;
}

}  // namespace

// Finds out whether keyframes hang on one, looking at each at most once. Children of that one may
// be hung on what does not hang on it meanwhile.
class Map::BranchFinder {
 public:
  BranchFinder(const Map& map, KeyframeId top) : map_(map), top_(top) {}

  bool IsBelowTop(KeyframeId id) {
    const KeyframeId branch = FindBranch(id);
    return branch.IsValid() && map_.FindKeyframe(branch)->parent == top_;
  }

 private:
  // The child of `top_` that it is, or hangs on; invalid for none.
  KeyframeId FindBranch(KeyframeId id) {
    std::vector<KeyframeId> way;
    KeyframeId branch;
    for (const Keyframe* at = map_.FindKeyframe(id); at != nullptr;
         at = map_.FindKeyframe(at->parent)) {
      if (const auto known = branch_of_.find(at->id()); known != branch_of_.end()) {
        branch = known->second;
        break;
      }
      way.push_back(at->id());
      if (at->parent != top_) continue;
      branch = at->id();
      break;
    }
    for (const KeyframeId& below : way) branch_of_[below] = branch;
    return branch;
  }

  const Map& map_;
  const KeyframeId top_;
  absl::flat_hash_map<KeyframeId, KeyframeId> branch_of_;
};

Map::Map(const Map& other)
    : keyframes_(other.keyframes_), points_(other.points_), covisibility_(other.covisibility_) {}

Map& Map::operator=(const Map& other) {
  if (this == &other) return *this;
  keyframes_ = other.keyframes_;
  points_ = other.points_;
  covisibility_ = other.covisibility_;
  observer_ = nullptr;
  return *this;
}

bool Map::AddKeyframe(Keyframe keyframe) {
  const KeyframeId id = keyframe.id();
  const KeyframeId parent = std::exchange(keyframe.parent, KeyframeId());
  const size_t keypoints =
      keyframe.keypoints().empty() ? keyframe.points.size() : keyframe.keypoints().size();
  keyframe.points.assign(keypoints, MapPointId());
  keyframe.children.clear();
  keyframe.covisible.clear();
  Keyframe* added = keyframes_.Add(id, std::move(keyframe));
  if (added == nullptr) return false;
  if (parent != id && FindKeyframe(parent) != nullptr) Attach(*added, parent);
  (observer_ ? *observer_ : Silent()).OnKeyframeAdded(id);
  return true;
}

bool Map::AddPoint(MapPoint point) {
  const MapPointId id = point.id;
  point.observations.clear();
  if (points_.Add(id, std::move(point)) == nullptr) return false;
  (observer_ ? *observer_ : Silent()).OnPointAdded(id);
  return true;
}

bool Map::Absorb(Map other) {
  const auto is_here = [this](const auto& item) {
    if constexpr (requires { item.second.observations; }) {
      return FindPoint(item.first) != nullptr;
    } else {
      return FindKeyframe(item.first) != nullptr;
    }
  };
  if (std::ranges::any_of(other.keyframes(), is_here)) return false;
  if (std::ranges::any_of(other.points(), is_here)) return false;
  keyframes_.Absorb(std::move(other.keyframes_));
  points_.Absorb(std::move(other.points_));
  return true;
}

void Map::SetPose(KeyframeId id, const Rigid3d& camera_from_map) {
  Keyframe* keyframe = keyframes_.Find(id);
  if (keyframe == nullptr) return;
  keyframe->camera_from_map = camera_from_map;
  (observer_ ? *observer_ : Silent()).OnKeyframeMoved(id);
}

void Map::SetPosition(MapPointId id, const Eigen::Vector3d& position_in_map) {
  MapPoint* point = points_.Find(id);
  if (point == nullptr) return;
  point->position_in_map = position_in_map;
  (observer_ ? *observer_ : Silent()).OnPointMoved(id);
}

void Map::SetWords(KeyframeId id, std::shared_ptr<const Words> words) {
  if (Keyframe* keyframe = keyframes_.Find(id)) keyframe->words = std::move(words);
}

void Map::DropFeatures(KeyframeId id) {
  Keyframe* keyframe = keyframes_.Find(id);
  if (keyframe == nullptr) return;
  keyframe->payload = WithFeatures(*keyframe->payload, Features());
}

bool Map::SetKeypoints(KeyframeId id, std::vector<Keypoint> keypoints) {
  Keyframe* keyframe = keyframes_.Find(id);
  if (keyframe == nullptr || keypoints.size() != keyframe->keypoints().size()) return false;
  if (observer_ != nullptr && !observer_->MayChangeKeypoints(id)) return false;
  const KeyframePayload& payload = *keyframe->payload;
  keyframe->payload =
      WithFeatures(payload, Features{std::move(keypoints), payload.features.descriptors});
  return true;
}

bool Map::IsAncestor(KeyframeId ancestor, KeyframeId id) const {
  const Keyframe* top = FindKeyframe(ancestor);
  if (top == nullptr || top->children.empty()) return top != nullptr && ancestor == id;
  for (const Keyframe* at = FindKeyframe(id); at != nullptr; at = FindKeyframe(at->parent)) {
    if (at->id() == ancestor) return true;
  }
  return false;
}

void Map::Attach(Keyframe& child, KeyframeId parent) {
  if (Keyframe* old = keyframes_.Find(child.parent)) old->children.erase(child.id());
  child.parent = parent;
  if (Keyframe* keyframe = keyframes_.Find(parent)) keyframe->children.insert(child.id());
}

bool Map::SetParent(KeyframeId child, KeyframeId parent) {
  Keyframe* keyframe = keyframes_.Find(child);
  if (keyframe == nullptr || FindKeyframe(parent) == nullptr) return false;
  if (keyframe->parent == parent) return true;
  if (IsAncestor(child, parent)) return false;
  Attach(*keyframe, parent);
  (observer_ ? *observer_ : Silent()).OnParentChanged(child);
  return true;
}

bool Map::AddLoopEdge(KeyframeId a, KeyframeId b) {
  Keyframe* first = keyframes_.Find(a);
  Keyframe* second = keyframes_.Find(b);
  if (first == nullptr || second == nullptr || first == second) return false;
  if (!first->loop_edges.insert(b).second) return false;
  second->loop_edges.insert(a);
  (observer_ ? *observer_ : Silent()).OnLoopEdgeAdded(a, b);
  return true;
}

bool Map::SetCovisibility(KeyframeId a, KeyframeId b, int weight) {
  Keyframe* first = keyframes_.Find(a);
  Keyframe* second = keyframes_.Find(b);
  if (covisibility_ != Covisibility::kGiven) return false;
  if (first == nullptr || second == nullptr || first == second) return false;
  first->covisible[b] = weight;
  second->covisible[a] = weight;
  return true;
}

void Map::ForgetCovisibility(const Keyframe& removed) {
  for (const auto& [id, weight] : removed.covisible) {
    keyframes_.Find(id)->covisible.erase(removed.id());
  }
}

void Map::ChangeCovisibility(const MapPoint& point, Keyframe& keyframe, int change) {
  if (covisibility_ == Covisibility::kGiven) return;
  for (const auto& [other_id, keypoint] : point.observations) {
    if (other_id == keyframe.id()) continue;
    Keyframe& other = *keyframes_.Find(other_id);
    const int weight = keyframe.covisible[other_id] += change;
    other.covisible[keyframe.id()] = weight;
    if (weight > 0) continue;
    keyframe.covisible.erase(other_id);
    other.covisible.erase(keyframe.id());
  }
}

void Map::Connect(MapPoint& point, Keyframe& keyframe, uint32_t keypoint) {
  ChangeCovisibility(point, keyframe, 1);
  point.observations.emplace(keyframe.id(), keypoint);
  keyframe.points[keypoint] = point.id;
}

void Map::Disconnect(MapPoint& point, Keyframe& keyframe) {
  const auto it = point.observations.find(keyframe.id());
  keyframe.points[it->second] = MapPointId();
  point.observations.erase(it);
  ChangeCovisibility(point, keyframe, -1);
}

bool Map::Observe(MapPoint& point, Keyframe& keyframe, uint32_t keypoint) {
  if (keypoint >= keyframe.points.size() || keyframe.points[keypoint].IsValid()) return false;
  if (point.observations.contains(keyframe.id())) return false;
  Connect(point, keyframe, keypoint);
  (observer_ ? *observer_ : Silent()).OnObservationAdded(point.id, keyframe.id(), keypoint);
  return true;
}

bool Map::AddObservation(MapPointId point_id, KeyframeId keyframe_id, uint32_t keypoint) {
  MapPoint* point = points_.Find(point_id);
  Keyframe* keyframe = keyframes_.Find(keyframe_id);
  if (point == nullptr || keyframe == nullptr) return false;
  return Observe(*point, *keyframe, keypoint);
}

void Map::AddObservations(KeyframeId keyframe_id, const std::vector<MapPointId>& points) {
  Keyframe* keyframe = keyframes_.Find(keyframe_id);
  if (keyframe == nullptr) return;
  for (uint32_t keypoint = 0; keypoint < points.size(); ++keypoint) {
    if (!points[keypoint].IsValid()) continue;
    if (MapPoint* point = points_.Find(points[keypoint])) Observe(*point, *keyframe, keypoint);
  }
}

bool Map::RemoveObservation(MapPointId point_id, KeyframeId keyframe_id) {
  MapPoint* point = points_.Find(point_id);
  if (point == nullptr) return false;
  const auto it = point->observations.find(keyframe_id);
  if (it == point->observations.end()) return false;
  const uint32_t keypoint = it->second;
  Disconnect(*point, *keyframes_.Find(keyframe_id));
  (observer_ ? *observer_ : Silent()).OnObservationRemoved(point_id, keyframe_id, keypoint);
  return true;
}

bool Map::ReplacePoint(MapPointId replaced_id, MapPointId survivor_id) {
  MapPoint* replaced = points_.Find(replaced_id);
  MapPoint* survivor = points_.Find(survivor_id);
  if (replaced == nullptr || survivor == nullptr || replaced == survivor) return false;
  const auto observations = replaced->observations;
  for (const auto& [keyframe_id, keypoint] : observations) {
    Keyframe& keyframe = *keyframes_.Find(keyframe_id);
    Disconnect(*replaced, keyframe);
    if (!survivor->observations.contains(keyframe_id)) Connect(*survivor, keyframe, keypoint);
  }
  points_.Erase(replaced_id);
  (observer_ ? *observer_ : Silent()).OnPointReplaced(replaced_id, survivor_id);
  return true;
}

bool Map::RemovePoint(MapPointId id) {
  MapPoint* point = points_.Find(id);
  if (point == nullptr) return false;
  while (!point->observations.empty()) {
    Disconnect(*point, *keyframes_.Find(point->observations.begin()->first));
  }
  points_.Erase(id);
  (observer_ ? *observer_ : Silent()).OnPointRemoved(id);
  return true;
}

KeyframeId Map::ChooseNewParent(const Keyframe& child, const Keyframe& removed,
                                BranchFinder& branches) const {
  for (const CovisibleKeyframe& candidate : SortByWeight(child, 1)) {
    // Another robot's keyframe moves without what hangs on it.
    if (candidate.id.local_map != child.id().local_map || candidate.id == removed.id()) continue;
    // A relative that still hangs on the removed keyframe would lose its own way to the root.
    if (branches.IsBelowTop(candidate.id)) continue;
    return candidate.id;
  }
  return removed.parent;
}

void Map::RehangChildren(const Keyframe& removed) {
  MapObserver& observer = observer_ ? *observer_ : Silent();
  const absl::btree_set<KeyframeId> children = removed.children;
  BranchFinder branches(*this, removed.id());
  KeyframeId heir;  // First child of a removed root, which becomes the root.
  for (const KeyframeId& child_id : children) {
    Keyframe& child = *keyframes_.Find(child_id);
    KeyframeId parent = removed.parent.IsValid() ? ChooseNewParent(child, removed, branches) : heir;
    if (!heir.IsValid()) heir = child_id;
    Attach(child, parent);
    observer.OnParentChanged(child_id);
  }
}

bool Map::RemoveKeyframe(KeyframeId id) {
  Keyframe* keyframe = keyframes_.Find(id);
  if (keyframe == nullptr) return false;
  for (const MapPointId& point_id : std::vector<MapPointId>(keyframe->points)) {
    if (point_id.IsValid()) Disconnect(*points_.Find(point_id), *keyframe);
  }
  ForgetCovisibility(*keyframe);
  KeyframeId parent = keyframe->parent;
  if (!parent.IsValid() && !keyframe->children.empty()) parent = *keyframe->children.begin();
  Rigid3d parent_from_removed;
  if (const Keyframe* relative = FindKeyframe(parent)) {
    parent_from_removed = relative->camera_from_map * keyframe->camera_from_map.Inverse();
  }
  RehangChildren(*keyframe);
  for (const KeyframeId& other : keyframe->loop_edges) keyframes_.Find(other)->loop_edges.erase(id);
  if (Keyframe* relative = keyframes_.Find(keyframe->parent)) relative->children.erase(id);
  keyframes_.Erase(id);
  (observer_ ? *observer_ : Silent()).OnKeyframeRemoved(id, parent, parent_from_removed);
  return true;
}

std::vector<CovisibleKeyframe> Map::Covisible(KeyframeId id, int min_weight) const {
  const Keyframe* keyframe = FindKeyframe(id);
  return keyframe ? SortByWeight(*keyframe, min_weight) : std::vector<CovisibleKeyframe>();
}

std::vector<CovisibleKeyframe> Map::BestCovisible(KeyframeId id, int count) const {
  std::vector<CovisibleKeyframe> best = Covisible(id, 1);
  if (best.size() > static_cast<size_t>(count)) best.resize(static_cast<size_t>(count));
  return best;
}

}  // namespace corbslam

#include "slam/optimisation/bundle_scope.h"

#include <algorithm>

#include "absl/container/btree_set.h"
#include "slam/map/own_sight.h"

namespace corbslam {
namespace {

constexpr int kMinCovisibility = 15;

KeyframeId RootOf(const Map& map) {
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (!keyframe.parent.IsValid()) return id;
  }
  return {};
}

bool IsRoot(const Keyframe& keyframe) { return !keyframe.parent.IsValid(); }

// Returns the keyframes of `own` among `centre` and its covisible ones.
absl::btree_set<KeyframeId> OwnAround(const Map& map, KeyframeId centre, LocalMapId own) {
  absl::btree_set<KeyframeId> near;
  if (centre.local_map == own) near.insert(centre);
  for (const CovisibleKeyframe& neighbour : map.Covisible(centre, kMinCovisibility)) {
    if (neighbour.id.local_map == own) near.insert(neighbour.id);
  }
  return near;
}

}  // namespace

BundleScope LocalBundleScope(const Map& map, KeyframeId centre, LocalMapId own) {
  if (map.FindKeyframe(centre) == nullptr) return {};
  const absl::btree_set<KeyframeId> near = OwnAround(map, centre, own);
  absl::btree_set<KeyframeId> free;
  absl::btree_set<KeyframeId> fixed;
  absl::btree_set<MapPointId> seen;
  for (const KeyframeId id : near) {
    const Keyframe& keyframe = *map.FindKeyframe(id);
    (IsRoot(keyframe) ? fixed : free).insert(id);
    for (const MapPointId point : keyframe.points) {
      if (point.IsValid()) seen.insert(point);
    }
  }
  BundleScope scope;
  for (const MapPointId id : seen) {
    const MapPoint& point = *map.FindPoint(id);
    if (id.local_map != own && !IsLocatedBy(own, point)) continue;
    scope.free_points.push_back(id);
    for (const auto& [observer, keypoint] : point.observations) {
      if (observer.local_map == own && !free.contains(observer)) fixed.insert(observer);
    }
  }
  if (fixed.empty() && !free.empty()) fixed.insert(free.extract(free.begin()).value());
  scope.free_keyframes.assign(free.begin(), free.end());
  scope.fixed_keyframes.assign(fixed.begin(), fixed.end());
  return scope;
}

BundleScope GlobalBundleScope(const Map& map, absl::Span<const KeyframeId> fixed) {
  absl::btree_set<KeyframeId> held;
  for (const KeyframeId id : fixed) {
    if (map.FindKeyframe(id) != nullptr) held.insert(id);
  }
  if (held.empty() && !map.keyframes().empty()) held.insert(RootOf(map));
  BundleScope scope;
  for (const auto& [id, keyframe] : map.keyframes()) {
    (held.contains(id) ? scope.fixed_keyframes : scope.free_keyframes).push_back(id);
  }
  for (const auto& [id, point] : map.points()) scope.free_points.push_back(id);
  return scope;
}

}  // namespace corbslam

#include "slam/optimisation/bundle_scope.h"

#include <algorithm>

#include "absl/container/btree_set.h"

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

// All of `near` are in the map.
BundleScope ScopeOf(const Map& map, const absl::btree_set<KeyframeId>& near, LocalMapId own) {
  absl::btree_set<KeyframeId> free;
  absl::btree_set<KeyframeId> fixed;
  for (const KeyframeId id : near) {
    const bool moves = id.local_map == own && !IsRoot(*map.FindKeyframe(id));
    (moves ? free : fixed).insert(id);
  }
  absl::btree_set<MapPointId> seen;
  for (const KeyframeId id : near) {
    if (id.local_map != own) continue;
    for (const MapPointId point : map.FindKeyframe(id)->points) {
      if (point.IsValid()) seen.insert(point);
    }
  }
  BundleScope scope;
  for (const MapPointId id : seen) {
    (id.local_map == own ? scope.free_points : scope.fixed_points).push_back(id);
    if (id.local_map != own) continue;
    for (const auto& [observer, keypoint] : map.FindPoint(id)->observations) {
      if (!free.contains(observer)) fixed.insert(observer);
    }
  }
  if (fixed.empty() && !free.empty()) fixed.insert(free.extract(free.begin()).value());
  scope.free_keyframes.assign(free.begin(), free.end());
  scope.fixed_keyframes.assign(fixed.begin(), fixed.end());
  return scope;
}

}  // namespace

BundleScope LocalBundleScope(const Map& map, KeyframeId centre, LocalMapId own) {
  if (map.FindKeyframe(centre) == nullptr) return {};
  absl::btree_set<KeyframeId> near = {centre};
  for (const CovisibleKeyframe& neighbour : map.Covisible(centre, kMinCovisibility)) {
    near.insert(neighbour.id);
  }
  return ScopeOf(map, near, own);
}

BundleScope LocalBundleScope(const Map& map, absl::Span<const KeyframeId> centres, LocalMapId own) {
  absl::btree_set<KeyframeId> near;
  for (const KeyframeId id : centres) {
    if (map.FindKeyframe(id) != nullptr) near.insert(id);
  }
  return ScopeOf(map, near, own);
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

// Implements Map::CopyPart.
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "slam/map/map.h"

namespace corbslam {
namespace {

// Copies the keyframe with those of its edges that stay among `kept`, and no points.
Keyframe CopyWithin(const Keyframe& original, const absl::flat_hash_set<KeyframeId>& kept) {
  Keyframe copy;
  copy.payload = original.payload;
  copy.words = original.words;
  copy.camera_from_map = original.camera_from_map;
  copy.points.resize(original.points.size());
  for (const auto& [id, weight] : original.covisible) {
    if (kept.contains(id)) copy.covisible.emplace_hint(copy.covisible.end(), id, weight);
  }
  if (kept.contains(original.parent)) copy.parent = original.parent;
  for (const KeyframeId child : original.children) {
    if (kept.contains(child)) copy.children.insert(child);
  }
  for (const KeyframeId other : original.loop_edges) {
    if (kept.contains(other)) copy.loop_edges.insert(other);
  }
  return copy;
}

}  // namespace

Map Map::CopyPart(const std::vector<KeyframeId>& keyframes,
                  const std::vector<MapPointId>& points) const {
  const absl::flat_hash_set<KeyframeId> kept(keyframes.begin(), keyframes.end());
  Map part(Covisibility::kGiven);
  for (const KeyframeId id : keyframes) {
    const Keyframe* keyframe = FindKeyframe(id);
    if (keyframe != nullptr) part.keyframes_.Add(id, CopyWithin(*keyframe, kept));
  }
  for (const MapPointId id : points) {
    const MapPoint* original = FindPoint(id);
    if (original == nullptr) continue;
    MapPoint copy = *original;
    copy.observations.clear();
    for (const auto& [keyframe_id, keypoint] : original->observations) {
      Keyframe* keyframe = part.keyframes_.Find(keyframe_id);
      if (keyframe == nullptr) continue;
      copy.observations.emplace_hint(copy.observations.end(), keyframe_id, keypoint);
      keyframe->points[keypoint] = id;
    }
    part.points_.Add(id, std::move(copy));
  }
  return part;
}

}  // namespace corbslam

#include "map_store/sharing/global_place.h"

#include <iterator>

#include "slam/geometry/same_motion.h"

namespace corbslam::map_store {
namespace {

// Returns the keyframe of the local map that has the greatest id of those that fusion placed; null
// if there is none.
const PlacedKeyframe* FindNewestPlaced(LocalMapId local_map, const PlacedKeyframes& placed) {
  const auto after = placed.upper_bound(KeyframeId{local_map, KeyframeId::kNoIndex});
  if (after == placed.begin()) return nullptr;
  const auto& [id, keyframe] = *std::prev(after);
  return id.local_map == local_map ? &keyframe : nullptr;
}

}  // namespace

std::optional<Similarity3d> FindGlobalPlace(const MissionState& state,
                                            const LocalMapState& local_map) {
  const GlobalLayer& global = state.global;
  if (local_map.map.keyframes().empty()) return std::nullopt;
  if (global.island_of.at(local_map.id) != state.ReferenceIsland()) return std::nullopt;
  if (const PlacedKeyframe* newest = FindNewestPlaced(local_map.id, global.keyframes)) {
    return newest->camera_from_island.Inverse() *
           Similarity3d::FromRigid(newest->camera_from_local);
  }
  const auto whole = global.island_from_local.find(local_map.id);
  return whole == global.island_from_local.end() ? Similarity3d::Identity() : whole->second;
}

std::optional<Similarity3d> TakeGlobalPlace(const MissionState& state, ShareState& share) {
  const auto place = FindGlobalPlace(state, *state.FindLocalMap(share.local_map));
  if (!place.has_value()) return std::nullopt;
  if (share.global_from_local && AreSame(*share.global_from_local, *place)) return std::nullopt;
  share.global_from_local = place;
  return place;
}

}  // namespace corbslam::map_store

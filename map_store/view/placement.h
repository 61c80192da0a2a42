// Where everything stands in its island's frame: placed keyframes where fusion put them, the others
// by their nearest placed relative. No seam, no frozen transform (docs/architecture.md).
#ifndef CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_
#define CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_

#include <memory>
#include <set>

#include "absl/container/flat_hash_map.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Placed keyframes to treat as if they were not.
using Unplaced = std::set<KeyframeId>;

// Poses of all keyframes of a local map. Those without a placed relative in their spanning tree
// follow the placed keyframe that came last before them; a local map without any placed keyframe
// stands where it stood last, or in its own frame.
IslandPoses ComputePoses(const LocalMapState& local_map, const GlobalLayer& global,
                         const Unplaced& unplaced = {});
// Likewise with these placed keyframes, and `last` for where it stood last; null: its own frame.
IslandPoses ComputePoses(const LocalMapState& local_map, const PlacedKeyframes& placed,
                         const Similarity3d* last, const Unplaced& unplaced = {});

// ComputePoses as the state is now, computed once for all who ask until it is another.
std::shared_ptr<const PoseTable> FindPoses(const MissionState& state,
                                           const LocalMapState& local_map);

// ComputePoses of one local map after the other, each once. Of a state that stays as it is.
class PoseCache {
 public:
  // Neither is copied.
  PoseCache(const MissionState& state, const Unplaced& unplaced)
      : state_(state), unplaced_(unplaced) {}

  const IslandPoses& Of(const LocalMapState& local_map);
  // The state is another now.
  void Clear() { poses_.clear(); }

 private:
  const MissionState& state_;
  const Unplaced& unplaced_;
  absl::flat_hash_map<LocalMapId, std::shared_ptr<const IslandPoses>> poses_;
};

// Position of a living point of `local_map` in its island: fusion's own, where its reference
// keyframe is placed, or by its place relative to its reference keyframe. `poses` are those of the
// point's local map.
Eigen::Vector3d ComputePosition(const MapPoint& point, const LocalMapState& local_map,
                                const GlobalLayer& global, const IslandPoses& poses,
                                const Unplaced& unplaced = {});

// island_from_local by the keyframe that the point refers to, or the nearest to it that there is.
Similarity3d IslandFromLocal(KeyframeId reference, const LocalMapState& local_map,
                             const GlobalLayer& global, const IslandPoses& poses);
// Likewise by the keyframe that came last. `poses` must not be empty.
Similarity3d IslandFromLocal(const LocalMapState& local_map, const IslandPoses& poses);

// The keyframe that the point follows: its reference, or where that one was culled, the first one
// that sees it and was not.
KeyframeId ReferenceOf(const MapPoint& point, const GlobalLayer& global);

// The keyframe that stands for `id`: itself, or through removals the nearest living relative, with
// the pose of `id` relative to it. False when the chain ends.
struct LivingRelative {
  KeyframeId id;
  Rigid3d relative_from_id;
};
bool FindLivingRelative(const MissionState& state, KeyframeId id, LivingRelative& found);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_

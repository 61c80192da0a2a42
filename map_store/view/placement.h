// Says where everything stands in its island's frame: placed keyframes where fusion put them,
// others by their nearest placed relative. There is no seam or frozen transform
// (docs/architecture.md).
#ifndef CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_
#define CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_

#include <memory>
#include <set>

#include "absl/container/flat_hash_map.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Placed keyframes that are to be treated as if they were not.
using Unplaced = std::set<KeyframeId>;

// Returns the poses of all keyframes of a local map. Those without a placed relative in their
// spanning tree follow the placed keyframe that came last before them; a local map without any
// placed keyframe stands where it stood last, or in its own frame.
IslandPoses ComputePoses(const LocalMapState& local_map, const GlobalLayer& global,
                         const Unplaced& unplaced = {});
// Does the same with these placed keyframes; the local map stood last at `last` (null: own frame).
IslandPoses ComputePoses(const LocalMapState& local_map, const PlacedKeyframes& placed,
                         const Similarity3d* last, const Unplaced& unplaced = {});

// Returns ComputePoses of the state, computed once for all callers until the state is another.
std::shared_ptr<const PoseTable> FindPoses(const MissionState& state,
                                           const LocalMapState& local_map);

// Computes the poses of each local map once. The state must stay as it is. Not thread-safe.
class PoseCache {
 public:
  // Neither argument is copied.
  PoseCache(const MissionState& state, const Unplaced& unplaced)
      : state_(state), unplaced_(unplaced) {}

  const IslandPoses& Of(const LocalMapState& local_map);
  // The caller says that the state has changed.
  void Clear() { poses_.clear(); }

 private:
  const MissionState& state_;
  const Unplaced& unplaced_;
  absl::flat_hash_map<LocalMapId, std::shared_ptr<const IslandPoses>> poses_;
};

// Returns the position of a living point of `local_map` in its island: fusion's own, if its
// reference keyframe is placed, or else by its place relative to its reference keyframe. `poses`
// are those of the point's local map.
Eigen::Vector3d ComputePosition(const MapPoint& point, const LocalMapState& local_map,
                                const GlobalLayer& global, const IslandPoses& poses,
                                const Unplaced& unplaced = {});

// Returns island_from_local by the keyframe that the point refers to, or the nearest to it that
// there is.
Similarity3d IslandFromLocal(KeyframeId reference, const LocalMapState& local_map,
                             const GlobalLayer& global, const IslandPoses& poses);
// Returns island_from_local by the keyframe that came last. `poses` must not be empty.
Similarity3d IslandFromLocal(const LocalMapState& local_map, const IslandPoses& poses);

// Returns the keyframe that the point follows: its reference or, if that one was culled, the first
// one that sees the point and was not.
KeyframeId ReferenceOf(const MapPoint& point, const GlobalLayer& global);

// Finds the keyframe that stands for `id`: that one itself or, if it was removed, its nearest
// living relative, with the pose of `id` relative to it. Returns false if the chain of removals
// ends.
struct LivingRelative {
  KeyframeId id;
  Rigid3d relative_from_id;
};
bool FindLivingRelative(const MissionState& state, KeyframeId id, LivingRelative& found);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_

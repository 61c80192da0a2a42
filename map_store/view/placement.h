// Says where everything stands in its island's frame: placed keyframes where fusion put them,
// others by their nearest placed relative. There is no seam or frozen transform
// (docs/architecture.md).
#ifndef CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_
#define CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_

#include <algorithm>
#include <memory>
#include <optional>
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

// A point that is placed, and the keyframe that it is anchored in.
struct PlacedAnchor {
  const PlacedPoint* point = nullptr;
  const PlacedKeyframe* keyframe = nullptr;

  Eigen::Vector3d PositionInIsland() const {
    return keyframe->camera_from_island.Inverse() * point->position_in_anchor;
  }
  // The last revision that put the point where it is.
  uint64_t revision() const { return std::max(point->revision, keyframe->moved_by); }
};
// Returns nullopt where the point is not placed, or its anchor is not any more.
std::optional<PlacedAnchor> FindPlaced(MapPointId id, const GlobalLayer& global);

// Places many points: each keyframe that they are anchored in is looked up once. The global layer
// must stay as it is. Not thread-safe.
class AnchorCache {
 public:
  // `global` is not copied.
  explicit AnchorCache(const GlobalLayer& global) : global_(global) {}

  const GlobalLayer& global() const { return global_; }
  // Returns nullopt where FindPlaced does, or where the anchor is in `unplaced`.
  std::optional<Eigen::Vector3d> FindPosition(MapPointId id, const Unplaced& unplaced);
  // The caller says that the global layer has changed.
  void Clear() { island_from_anchor_.clear(); }

 private:
  const GlobalLayer& global_;
  absl::flat_hash_map<KeyframeId, std::optional<Similarity3d>> island_from_anchor_;
};

// Returns the keyframe in which a living point that lies at `position_in_island` is to be anchored,
// and its place there: the one that it follows or, if that is not placed, the first one of those
// that see it. Nullopt: none of them is placed. `revision` put the point where it lies.
std::optional<PlacedPoint> Anchor(const MapPoint& point, const Eigen::Vector3d& position_in_island,
                                  uint64_t revision, const GlobalLayer& global,
                                  const PlacedKeyframes& placed);

// Returns the position of a living point of `local_map` in its island: fusion's own, if its
// reference keyframe is placed, or else by its place relative to its reference keyframe. `poses`
// are those of the point's local map.
Eigen::Vector3d ComputePosition(const MapPoint& point, const LocalMapState& local_map,
                                const GlobalLayer& global, const IslandPoses& poses,
                                const Unplaced& unplaced = {});
// The same for who places many.
Eigen::Vector3d ComputePosition(const MapPoint& point, const LocalMapState& local_map,
                                AnchorCache& anchors, const IslandPoses& poses,
                                const Unplaced& unplaced);

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
// ends. Of a keyframe that the store let go of, the global layer knows a stand-in, and the local
// layer an ancestor of its own local map.
enum class RelativeIn { kGlobalLayer, kLocalLayer };
struct LivingRelative {
  KeyframeId id;
  Rigid3d relative_from_id;
};
bool FindLivingRelative(const MissionState& state, KeyframeId id, LivingRelative& found,
                        RelativeIn layer = RelativeIn::kGlobalLayer);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_PLACEMENT_H_

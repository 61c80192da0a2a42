// Remembers what became of the items that a map holds no more, so that references to them can be
// followed.
#ifndef CORBSLAM_CLIENT_AGENT_MAP_MAP_HISTORY_H_
#define CORBSLAM_CLIENT_AGENT_MAP_MAP_HISTORY_H_

#include <optional>

#include "absl/container/flat_hash_map.h"
#include "slam/map/map.h"
#include "slam/map/map_observer.h"

namespace corbslam {

// Observes one map and passes every change on. Not thread-safe; GuardedMap guards it together with
// its map.
class MapHistory : public MapObserver {
 public:
  // `next` hears everything too; it is not owned, null for none.
  void SetNext(MapObserver* next) { next_ = next; }

  // Returns the point that took the place of `id`, or `id` itself.
  MapPointId CurrentPoint(MapPointId id) const;

  // Returns the pose of a keyframe that is or was in `map`: a removed one follows the parent it
  // hung on. There is none for keyframes never seen.
  std::optional<Rigid3d> CameraFromMap(const Map& map, KeyframeId id) const;

  void OnKeyframeAdded(KeyframeId id) override;
  void OnKeyframeMoved(KeyframeId id) override;
  void OnParentChanged(KeyframeId id) override;
  void OnLoopEdgeAdded(KeyframeId a, KeyframeId b) override;
  void OnKeyframeRemoved(KeyframeId id, KeyframeId parent,
                         const Rigid3d& parent_from_removed) override;
  void OnPointAdded(MapPointId id) override;
  void OnPointMoved(MapPointId id) override;
  void OnObservationAdded(MapPointId point, KeyframeId keyframe, uint32_t keypoint) override;
  void OnObservationRemoved(MapPointId point, KeyframeId keyframe, uint32_t keypoint) override;
  void OnPointReplaced(MapPointId replaced, MapPointId survivor) override;
  void OnPointRemoved(MapPointId id) override;
  bool MayChangeKeypoints(KeyframeId id) const override;

 private:
  struct Removal {
    KeyframeId parent;
    Rigid3d parent_from_removed;
  };

  MapObserver* next_ = nullptr;
  absl::flat_hash_map<KeyframeId, Removal> removed_keyframes_;
  absl::flat_hash_map<MapPointId, MapPointId> replaced_points_;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MAP_MAP_HISTORY_H_

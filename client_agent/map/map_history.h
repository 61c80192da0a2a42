// Remembers what became of the items that a map holds no more, so that references to them can be
// followed.
#ifndef CORBSLAM_CLIENT_AGENT_MAP_MAP_HISTORY_H_
#define CORBSLAM_CLIENT_AGENT_MAP_MAP_HISTORY_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "slam/map/map.h"
#include "slam/map/map_observer.h"

namespace corbslam::client_agent {

// Counts the items of a map that are of its own local map.
struct OwnItems {
  int keyframes = 0;
  int points = 0;
};

// Observes one map and passes every change on. Not thread-safe; GuardedMap guards it together with
// its map.
class MapHistory : public MapObserver {
 public:
  // Replaced points are remembered while they are among the newest so many: tracking and mapping
  // ask for those that a frame or a waiting keyframe named, which are seconds old.
  static constexpr size_t kMaxReplacements = 100'000;

  explicit MapHistory(LocalMapId own = {}, size_t max_replacements = kMaxReplacements)
      : own_(own), max_replacements_(max_replacements) {}

  // `next` hears everything too; it is not owned, null for none.
  void SetNext(MapObserver* next) { next_ = next; }

  // Returns what is in the map now, counted as it came and went.
  const OwnItems& own_items() const { return own_items_; }

  // Returns the point that took the place of `id`, or `id` itself where none did or that was long
  // ago.
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

  struct Replacement {
    MapPointId survivor;
    uint64_t number = 0;
  };
  void ForgetOldReplacements();

  const LocalMapId own_;
  const size_t max_replacements_;
  MapObserver* next_ = nullptr;
  OwnItems own_items_;
  // There are as many as keyframes were culled: poses of frames follow them as long as the map
  // lives.
  absl::flat_hash_map<KeyframeId, Removal> removed_keyframes_;
  absl::flat_hash_map<MapPointId, Replacement> replaced_points_;
  // In the order in which they were replaced. A point that came back and was replaced again is in
  // here twice; its number in replaced_points_ says which counts.
  std::deque<std::pair<MapPointId, uint64_t>> replacement_order_;
  uint64_t replacements_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAP_MAP_HISTORY_H_

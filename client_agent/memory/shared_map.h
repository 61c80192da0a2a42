// The robot's copy of what others made, and its place in the robot's own map (CORB-SLAM, section
// 2.3: others' data is used and held fixed).
#ifndef CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_
#define CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "slam/exchange/shared_update.h"
#include "slam/map/map.h"

namespace corbslam {

using ComputeWords =
    std::function<std::shared_ptr<const Words>(const std::vector<Descriptor>& descriptors)>;

// Foreign keyframes that came into, or went from, the robot's map.
struct PlacementChange {
  std::vector<KeyframeId> added_keyframes;
  std::vector<KeyframeId> removed_keyframes;
};

// Not thread-safe: used by the mapping thread, which alone writes the map.
class SharedMap {
 public:
  SharedMap(LocalMapId own, ComputeWords compute_words);

  // Takes over one step of the store's view. Call Place afterwards.
  void Apply(const SharedUpdate& update);

  // Brings `map` in line with what was applied: adds, moves and removes foreign items. Each source
  // local map is placed rigidly through one own keyframe that fusion has placed: the one most
  // covisible with that source, else the nearest. A landmark of which the robot itself holds a
  // point is that point, so that nothing is held twice.
  PlacementChange Place(Map& map);

  // Where the robot's frame is in the global one, by the own keyframe placed last; none before
  // fusion.
  std::optional<Similarity3d> GlobalFromLocal(const Map& map) const;

  size_t keyframe_count() const { return keyframes_.size(); }

 private:
  struct ForeignKeyframe {
    std::shared_ptr<const KeyframePayload> payload;
    std::shared_ptr<const Words> words;
    Similarity3d camera_from_global;
    KeyframeId parent;
    std::vector<MapPointId> points;
  };
  // A source local map's placing, to see whether it moved.
  struct Placing {
    Rigid3d local_from_global;
    bool changed = true;
  };

  void ApplyObservation(const ObservationChange& change);
  void MarkChanged(LocalMapId source) { placings_[source].changed = true; }
  // The point that stands for `id` in the robot's map.
  MapPointId Representative(const Map& map, MapPointId id) const;
  // Own keyframes that fusion has placed; none where there is none, or none sees what the source
  // has.
  KeyframeId MostCovisible(const Map& map, LocalMapId source) const;
  KeyframeId Nearest(const Map& map, LocalMapId source) const;
  Rigid3d LocalFromGlobal(const Map& map, KeyframeId anchor) const;
  void RemoveGone(Map& map, PlacementChange& change);
  void MergeDuplicates(Map& map) const;
  // False: there is no own keyframe to place it by yet.
  bool PlaceSource(LocalMapId source, Map& map, PlacementChange& change);
  void PlaceKeyframes(LocalMapId source, const Rigid3d& local_from_global, Map& map,
                      PlacementChange& change);
  void PlacePoints(LocalMapId source, const Rigid3d& local_from_global, Map& map);
  void PlaceObservations(LocalMapId source, Map& map);

  const LocalMapId own_;
  const ComputeWords compute_words_;
  std::map<KeyframeId, ForeignKeyframe> keyframes_;
  std::map<MapPointId, SharedMapPoint> points_;
  std::map<MapPointId, MapPointId> survivor_of_;
  std::map<MapPointId, std::vector<MapPointId>> own_members_;  // By survivor.
  std::map<KeyframeId, Similarity3d> own_from_global_;
  std::map<LocalMapId, Placing> placings_;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_

// The robot's copy of what others made, and its place in the robot's own map (CORB-SLAM, section
// 2.3: others' data is used and held fixed).
#ifndef CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_
#define CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_

#include <map>
#include <optional>
#include <vector>

#include "absl/container/btree_set.h"
#include "client_agent/memory/shared_content.h"
#include "slam/map/map.h"

namespace corbslam {

// Foreign keyframes that came into, or went from, the robot's map.
struct PlacementChange {
  std::vector<KeyframeId> added_keyframes;
  std::vector<KeyframeId> removed_keyframes;
};

// Not thread-safe: used by the mapping thread, which alone writes the map.
class SharedMap {
 public:
  explicit SharedMap(LocalMapId own) : content_(own) {}

  // Takes over one step of the store's view. Call Place afterwards.
  void Apply(const ArrivedUpdate& arrived) { content_.Apply(arrived); }

  // Brings `map` in line with what was applied: adds, moves and removes foreign items. Each source
  // local map is placed rigidly through one own keyframe that fusion has placed: the one most
  // covisible with that source, else the nearest. A landmark of which the robot itself holds a
  // point is that point, so that nothing is held twice. Costs what there is news of, and a walk
  // through a source's keyframes and points where it moved as a whole.
  PlacementChange Place(Map& map);

  // Where the robot's frame is in the global one, by the own keyframe placed last; none before
  // fusion.
  std::optional<Similarity3d> GlobalFromLocal(const Map& map) const;

  size_t keyframe_count() const { return content_.keyframes().size(); }

 private:
  // Own keyframes that fusion has placed; none where there is none, or none sees what the source
  // has.
  KeyframeId MostCovisible(const Map& map, LocalMapId source) const;
  KeyframeId Nearest(const Map& map, LocalMapId source) const;
  Rigid3d LocalFromGlobal(const Map& map, KeyframeId anchor) const;
  void RemoveGoneKeyframes(const SourceNews& news, Map& map, PlacementChange& change) const;
  // False: there is no own keyframe to place it by yet.
  bool PlaceSource(LocalMapId source, const SourceNews& news, Map& map, PlacementChange& change);
  void PlaceEverything(LocalMapId source, Map& map, PlacementChange& change);
  void PlaceKeyframe(KeyframeId id, const ForeignKeyframe& foreign, Map& map,
                     PlacementChange& change);
  void PlacePoint(MapPointId id, const SharedMapPoint& shared, Map& map);
  // Points that are gone, or that another one stands for.
  void DropPoints(const SourceNews& news, Map& map) const;
  void PlaceSights(KeyframeId id, Map& map) const;
  void HangOrphans(Map& map);
  void ForgetGone(SourceNews& news) const;

  SharedContent content_;
  // local_from_global of each source that is in the map.
  std::map<LocalMapId, Rigid3d> placings_;
  // Foreign keyframes whose parents are not in the map (yet).
  absl::btree_set<KeyframeId> orphans_;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_

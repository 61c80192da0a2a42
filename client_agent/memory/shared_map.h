// The robot's copy of what others made, and its place in the robot's own map (CORB-SLAM, section
// 2.3: others' data is used and held fixed).
#ifndef CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_
#define CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_

#include <map>
#include <optional>
#include <vector>

#include "absl/container/btree_set.h"
#include "client_agent/memory/placing_anchors.h"
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
  explicit SharedMap(LocalMapId own) : own_(own), content_(own) {}

  // Takes over one step of the store's view. Call Place afterwards.
  void Apply(const ArrivedUpdate& arrived) {
    content_.Apply(arrived);
    has_all_places_ = !arrived.update.more_places;
  }

  // The robot moved its own map as a whole, which `map` shows: what shares points with own
  // keyframes goes with them, but for what the own map was fitted to. Call Place afterwards.
  void Correct(const OwnCorrection& correction, Map& map);

  // Brings `map` in line with what was applied: adds, moves and removes foreign items. A foreign
  // keyframe that the robot's own sight holds where it is stays there; every other one is placed by
  // the nearest keyframe of which both places are known, an own one that fusion has placed or a
  // foreign one that stays; points go with the keyframe that they refer to. A landmark of which the
  // robot itself holds a point is that point, so that nothing is held twice. Costs what there is
  // news of or lies elsewhere now, and a search for the nearest for each foreign keyframe. Does
  // nothing while the store is telling what moved: part of it does not fit the rest.
  PlacementChange Place(Map& map);

  // Where the robot's frame is in the global one, by the own keyframe placed last; none before
  // fusion.
  std::optional<Similarity3d> GlobalFromLocal() const;

  size_t keyframe_count() const { return content_.keyframes().size(); }

 private:
  void RemoveGoneKeyframes(const SourceNews& news, Map& map, PlacementChange& change);
  // The foreign keyframes that stay, and where the global frame lies for them.
  std::map<KeyframeId, Rigid3d> FindHeld(const Map& map) const;
  PlacingAnchors ChooseAnchors(const Map& map, const std::map<KeyframeId, Rigid3d>& held) const;
  // Those that are news, or lie elsewhere now; then what refers to them.
  void PlaceKeyframes(Map& map, PlacementChange& change);
  void PlaceKeyframe(KeyframeId id, const ForeignKeyframe& foreign, Map& map,
                     PlacementChange& change);
  void PlacePoints(const std::vector<KeyframeId>& moved, Map& map);
  void MoveWithPoints(KeyframeId id, const Rigid3d& after_from_before, Map& map) const;
  void PlacePointsOf(KeyframeId id, const ForeignKeyframe& foreign, Map& map);
  void PlacePoint(MapPointId id, const SharedMapPoint& shared, Map& map);
  // local_from_global at the point; notes whether a keyframe says it.
  Rigid3d PlacingOf(const SharedMapPoint& point);
  // Points that are gone, or that another one stands for.
  void DropPoints(const SourceNews& news, Map& map) const;
  void PlaceSights(KeyframeId id, Map& map) const;
  void HangOrphans(Map& map);
  void ForgetGone(SourceNews& news) const;

  const LocalMapId own_;
  SharedContent content_;
  bool has_all_places_ = true;
  PlacingAnchors anchors_;
  // local_from_global of each foreign keyframe that is in the map.
  std::map<KeyframeId, Rigid3d> placings_;
  // Foreign points that no foreign keyframe places.
  absl::btree_set<MapPointId> points_alone_;
  // Foreign keyframes whose parents are not in the map (yet).
  absl::btree_set<KeyframeId> orphans_;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MEMORY_SHARED_MAP_H_

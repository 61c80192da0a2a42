// Keeps the robot's copy of what others made, and gives it its place in the robot's own map
// (CORB-SLAM, section 2.3: others' data is used and held fixed).
#ifndef CORBSLAM_CLIENT_AGENT_SHARED_SHARED_MAP_H_
#define CORBSLAM_CLIENT_AGENT_SHARED_SHARED_MAP_H_

#include <functional>
#include <optional>
#include <vector>

#include "absl/container/btree_set.h"
#include "client_agent/shared/placement_planner.h"
#include "client_agent/shared/shared_content.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// What the placing of others' keyframes did to the robot's map.
struct PlacementChange {
  std::vector<KeyframeId> added_keyframes;
  std::vector<KeyframeId> removed_keyframes;
  // Own keyframes, the oldest first, that lay where a local map would have them that is left out
  // since: they are to be adjusted anew, by what they see themselves.
  std::vector<KeyframeId> released_keyframes;
};

// The shared map is used by the mapping thread, which alone writes the robot's map; not
// thread-safe. Work that only reads the map is in Plan, so that tracking need not wait for it.
class SharedMap {
 public:
  explicit SharedMap(LocalMapId own) : own_(own), content_(own), planner_(own) {}

  // Takes over one step of the store's view. The caller calls Plan and Place afterwards.
  void Apply(const ArrivedUpdate& arrived);

  // Follows a correction by which the robot moved its own map as a whole, as `map` shows: foreign
  // keyframes that own ones pinned before go along, but for those that the own map was fitted to.
  // (What they see in common only since then, in the very loop that was closed, is no reason to
  // go.) The caller calls Plan and Place afterwards.
  void Correct(const OwnCorrection& correction, Map& map);

  // Gives up what a foreign local map said: it is taken out, and nothing of it is taken any more.
  // Points that own keyframes locate become own ones, under the names that `new_name` gives. The
  // caller calls Plan and Place afterwards.
  void LeaveOut(LocalMapId local_map, const std::function<MapPointId()>& new_name, Map& map);

  // Plans how to bring `map` in line with what was applied. Costs as much as there is news or lies
  // elsewhere now, and a search for the nearest anchor for each foreign keyframe.
  PlacementPlan Plan(const Map& map);

  // Carries out the plan: adds, moves and removes foreign items. `map` is as it was when the plan
  // was made, and nothing was applied since. A landmark of which the robot itself holds a point is
  // that point, so that nothing is held twice. Does nothing while the store is telling what moved,
  // because a part of that does not fit the rest.
  PlacementChange Place(const PlacementPlan& plan, Map& map);

  // Returns where the robot's frame is in the mission's global one: by the own keyframe placed last
  // or, before fusion placed any, as the store said of the local map as a whole. None where the
  // store said neither, or that the island is not connected to the global frame.
  std::optional<Similarity3d> GlobalFromLocal() const;
  // Returns whether the store said that places are in metres.
  bool in_metres() const { return in_metres_; }

  size_t keyframe_count() const { return content_.keyframes().size(); }

 private:
  // Returns true once fusion has placed own keyframes, or the store said where the robot's frame
  // lies as a whole, so that others' keyframes can be placed.
  bool CanPlace() const {
    return !content_.own_places().places().empty() || told_global_from_local_.has_value();
  }
  void RemoveGoneKeyframes(const SourceNews& news, Map& map, PlacementChange& change);
  void PlaceKeyframe(const PlacementPlan::PlacedKeyframe& placed, Map& map,
                     PlacementChange& change);
  void PlacePoint(const PlacementPlan::PlacedPoint& placed, Map& map);
  void MoveWithPoints(KeyframeId id, const Rigid3d& after_from_before, Map& map) const;
  // Takes out points that are gone, or that another one stands for.
  void DropPoints(const SourceNews& news, Map& map) const;
  void PlaceSights(KeyframeId id, Map& map) const;
  void HangOrphans(Map& map);
  void ForgetGone(SourceNews& news) const;

  const LocalMapId own_;
  SharedContent content_;
  PlacementPlanner planner_;
  bool has_all_places_ = true;
  bool apart_ = false;
  bool in_metres_ = false;
  std::optional<Similarity3d> told_global_from_local_;
  // Own keyframes that saw points of what is left out since the last Place.
  absl::btree_set<KeyframeId> released_;
  // Foreign keyframes whose parents are not in the map (yet).
  absl::btree_set<KeyframeId> orphans_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SHARED_SHARED_MAP_H_

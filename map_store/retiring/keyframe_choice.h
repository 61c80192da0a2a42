// Chooses keyframes of closed local maps that the others of their island can do without.
#ifndef CORBSLAM_MAP_STORE_RETIRING_KEYFRAME_CHOICE_H_
#define CORBSLAM_MAP_STORE_RETIRING_KEYFRAME_CHOICE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "map_store/retiring/landmark_sights.h"
#include "map_store/retiring/other_visits.h"
#include "map_store/retiring/retirement.h"
#include "map_store/retiring/retiring_view.h"

namespace corbslam::map_store {

struct ChoiceOptions {
  // A keyframe may go when this share of the landmarks that it observes, 0 to 1, is seen by
  // `min_others` other keyframes at the same or a finer scale (one level of slack; ORB-SLAM, T-RO
  // 2015, VI.E, over all sessions at once).
  double seen_share = 0.9;
  int min_others = 3;
  // Of at most this share it may be the last that observes a point of its own local map which
  // others observe and have no point of: these landmarks go with it.
  double max_homeless_share = 0.02;
  // What stands in for a keyframe shares at least so many landmarks with it: the covisibility that
  // makes keyframes neighbours.
  int min_shared = 15;
  // Where keyframes of so many other local maps look at the same place, a keyframe may go whatever
  // of it they see, by day and by night: so many visits of a place are enough. Those of which the
  // others see most go first, so that visits that differ are left.
  size_t max_visits = 3;
  // Such a keyframe may take more landmarks with it.
  double max_homeless_share_where_visited = 0.3;
  OtherVisitsOptions other_visits;
};

// Why candidates stay: how many for each reason, the first that holds.
struct StayCounts {
  size_t roots = 0;     // First keyframes of local maps that are no parts.
  size_t newest = 0;    // Nothing later looks at the place.
  size_t links = 0;     // Their overlap alone joins local maps.
  size_t homeless = 0;  // Others would lose too many landmarks.
  size_t unseen = 0;    // Too few others see what they see, and the place has visits to spare.
  size_t unplaced = 0;  // Nothing that stays could stand in.
};

std::string ToString(const StayCounts& counts);

// Returns the keyframes in the order in which they go, each judged by those that are left at its
// turn: those that hold no overlap before those that do, those of earlier local maps before later
// ones, those of which most is seen first. What the last local map that sees a place has of it
// stays, and so do the root of a local map that is no part of another, keyframes whose overlap
// alone joins local maps, and those that nothing stands in for. Then those go at whose
// places there are enough other visits, those of which most is seen first. `faded` landmarks don't
// count. Counts in `stays`, if given, what stays. Pure.
std::vector<RetiredKeyframe> ChooseKeyframes(const RetiringView& view,
                                             const SightsOfLandmarks& sights,
                                             const absl::flat_hash_set<MapPointId>& faded,
                                             const ChoiceOptions& options,
                                             StayCounts* stays = nullptr);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_KEYFRAME_CHOICE_H_

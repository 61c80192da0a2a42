// Chooses keyframes of closed local maps that the others of their island can do without.
#ifndef CORBSLAM_MAP_STORE_RETIRING_KEYFRAME_CHOICE_H_
#define CORBSLAM_MAP_STORE_RETIRING_KEYFRAME_CHOICE_H_

#include <vector>

#include "absl/container/flat_hash_set.h"
#include "map_store/retiring/landmark_sights.h"
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
};

// Returns the keyframes in the order in which they go, each judged by those that are left at its
// turn: those that hold no overlap before those that do, those of earlier local maps before later
// ones, those of which most is seen first. A local map's root stays, and so do keyframes whose
// overlap alone joins local maps, and those that nothing stands in for. `faded` landmarks don't
// count. Pure.
std::vector<RetiredKeyframe> ChooseKeyframes(const RetiringView& view,
                                             const SightsOfLandmarks& sights,
                                             const absl::flat_hash_set<MapPointId>& faded,
                                             const ChoiceOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_KEYFRAME_CHOICE_H_

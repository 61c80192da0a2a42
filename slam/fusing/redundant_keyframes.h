// Finds keyframes of a map that the others can do without (CORB-SLAM follows ORB-SLAM here:
// Mur-Artal, Montiel and Tardos, T-RO 2015, section VI.E), over all robots at once.
#ifndef CORBSLAM_SLAM_FUSING_REDUNDANT_KEYFRAMES_H_
#define CORBSLAM_SLAM_FUSING_REDUNDANT_KEYFRAMES_H_

#include <cstddef>
#include <vector>

#include "absl/container/btree_set.h"
#include "slam/map/map.h"

namespace corbslam {

struct RedundancyOptions {
  // A keyframe is redundant when this share of the points that it sees, 0 to 1, is seen by
  // `min_others` other keyframes at the same or a finer scale (one pyramid level of slack); 0: none
  // is.
  double seen_share = 0;
  int min_others = 3;
  // Where more are left than this, the most redundant of them go as well; 0: any number may stay.
  size_t target_keyframes = 0;
};

// Lists them in the order in which they go: each is judged by those that are left when its turn
// comes. One of `kept`, one without a parent, or one that sees no point never goes. Pure.
std::vector<KeyframeId> FindRedundantKeyframes(const Map& map,
                                               const absl::btree_set<KeyframeId>& kept,
                                               const RedundancyOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FUSING_REDUNDANT_KEYFRAMES_H_

// Measures the metres travelled along the truth, also where no frame was tracked.
#ifndef CORBSLAM_SLAM_EVALUATION_TRUE_TRAVEL_H_
#define CORBSLAM_SLAM_EVALUATION_TRUE_TRAVEL_H_

#include <vector>

#include "slam/evaluation/trajectory.h"

namespace corbslam {

// Travel along the true path: one entry a pair, in their order. It begins at the first pair.
struct TrueTravel {
  // Travel up to the pair's true pose.
  std::vector<double> at_m;
  // Travel up to the pose of the path before that, which may be of a lost frame.
  std::vector<double> before_m;
};

// Follows the true poses of `pairs` (in order of time) and, between two of them that are further
// apart in time than frames are, those of `truth` (sorted) in between, at the frames' rate: the
// median interval of the pairs, at most 0.1 s as of KITTI's truth. A truth of a higher rate is
// thinned to that: at 100 Hz its noise would count as travel. An empty `truth` adds nothing.
TrueTravel MeasureTravel(const std::vector<PosePair>& pairs, const Trajectory& truth);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EVALUATION_TRUE_TRAVEL_H_

// A camera's path: where it was at which time.
#ifndef CORBSLAM_SLAM_EVALUATION_TRAJECTORY_H_
#define CORBSLAM_SLAM_EVALUATION_TRAJECTORY_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/geometry/rigid3.h"

namespace corbslam {

struct StampedPose {
  int64_t timestamp_ns = 0;
  // "World" is whatever frame the trajectory is in: a local map's, the global one, the truth's.
  Rigid3d world_from_camera;
};

using Trajectory = std::vector<StampedPose>;

struct PosePair {
  StampedPose estimate;
  StampedPose truth;
};

// Largest difference in time between an estimate and the true pose that it is held against.
inline constexpr int64_t kMaxAssociationGap_ns = 20'000'000;

// Pairs each estimate with the true pose nearest in time, where one lies within `max_gap_ns` (at
// least 0), in the order of `estimate`. A true pose is used once: by the estimate that it is
// nearest to; the others take the next nearest that is free. `truth` must be sorted by time.
std::vector<PosePair> AssociateByTime(const Trajectory& estimate, const Trajectory& truth,
                                      int64_t max_gap_ns = kMaxAssociationGap_ns);

// Sorts by time; poses of equal time keep their order.
void SortByTime(Trajectory& trajectory);

// Returns the poses at or after `first_ns`.
Trajectory KeepFrom(const Trajectory& trajectory, int64_t first_ns);

// Merges several trajectories in the same frame into one: sorted by time, and of equal times the
// first named wins.
Trajectory MergeByTime(const std::vector<Trajectory>& trajectories);

// Returns the metres of travel.
double PathLength_m(const Trajectory& trajectory);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EVALUATION_TRAJECTORY_H_

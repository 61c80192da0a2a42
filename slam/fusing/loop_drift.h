// Tells whether odometry can have drifted as far as a loop says.
#ifndef CORBSLAM_SLAM_FUSING_LOOP_DRIFT_H_
#define CORBSLAM_SLAM_FUSING_LOOP_DRIFT_H_

#include "slam/fusing/fusing_graph.h"

namespace corbslam {

// Returns how far a loop would move its keyframe, or what lies before it at the scene's depth, as a
// share of what drift explains (MapFusingOptions::max_drift); above 1 it is no drift. The way
// around the loop is the shortest through its local map's essential graph. For a new overlap that
// is alone it may also lead through other local maps, over earlier overlaps that agree with where
// the keyframes are: the others were outvoted, or a local map has bent itself since. Several new
// ones may find an earlier one wrong: what that joined is no way for them. The result is 0 where
// there is no way, and for an overlap between the two maps.
double DriftOfLoop(const FusingProblem& problem, const OrientedOverlap& loop,
                   const MapFusingOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FUSING_LOOP_DRIFT_H_

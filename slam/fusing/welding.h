// After the graph is solved, points that are there twice become one, and the seam is adjusted.
#ifndef CORBSLAM_SLAM_FUSING_WELDING_H_
#define CORBSLAM_SLAM_FUSING_WELDING_H_

#include <map>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/fusing/fusing_graph.h"

namespace corbslam {

struct WeldingResult {
  std::vector<FuseMapsResult::Merge> merges;
  // Poses of the adjusted keyframes, in the target's frame and unit.
  std::map<KeyframeId, Rigid3d> poses;
  std::map<MapPointId, Eigen::Vector3d> positions;
  std::vector<RejectedObservation> rejected;
};

// Works on the neighbourhoods of the new overlaps. `positions` are those of all points after the
// graph was solved, in the target's frame. Everything outside the window stays where the graph put
// it, and holds the window.
absl::StatusOr<WeldingResult> Weld(const FusingProblem& problem, const SolvedGraph& graph,
                                   const std::map<MapPointId, Eigen::Vector3d>& positions,
                                   const MapFusingOptions& options,
                                   const ProgressCallback& progress);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FUSING_WELDING_H_

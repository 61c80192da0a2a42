// How far an estimated trajectory is from the truth. Absolute error after one best alignment
// (Umeyama, PAMI 1991; as used by Sturm et al., IROS 2012) and KITTI's relative errors over
// segments (Geiger et al., CVPR 2012).
#ifndef CORBSLAM_SLAM_EVALUATION_TRAJECTORY_ERROR_H_
#define CORBSLAM_SLAM_EVALUATION_TRAJECTORY_ERROR_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

enum class Alignment { kSe3, kSim3 };

struct AbsoluteError {
  Similarity3d truth_from_estimate;
  // Root mean square and others of the distances between aligned and true camera centres.
  double rmse_m = 0;
  double mean_m = 0;
  double median_m = 0;
  double max_m = 0;
  size_t poses = 0;
};

// Aligns the camera centres of all pairs at once: give the pairs of several robots together for a
// fused error under ONE alignment. FAILED_PRECONDITION with fewer than 3 pairs.
absl::StatusOr<AbsoluteError> ComputeAbsoluteError(const std::vector<PosePair>& pairs,
                                                   Alignment alignment);

struct RelativeError {
  double translation_percent = 0;
  double rotation_deg_per_100m = 0;
  int segments = 0;
};

// Returns the mean error over all segments of 100, 200, ... 800 m of true travel that begin at
// every `first_pose_step`-th pair and fit. Travel is that along `truth` (MeasureTravel), however
// many frames were lost on the way. As in KITTI's devkit a segment ends with the first frame beyond
// its length. Where frames were lost there, its error is divided by the travel up to the end that
// it has; with more than a tenth of the length too much there is no such segment. Pairs must be in
// order of time; nullopt when none fits.
std::optional<RelativeError> ComputeRelativeError(const std::vector<PosePair>& pairs,
                                                  const Trajectory& truth,
                                                  int first_pose_step = 10);

// Returns the mean over all segments of several paths; nullopt where there is none.
std::optional<RelativeError> MeanOverSegments(const std::vector<RelativeError>& errors);

// The mean relative error over segments of one length.
struct LengthError {
  double length_m = 0;
  RelativeError error;
};

// Returns the same errors by the segments' length, ascending; lengths that never fit are left out.
std::vector<LengthError> ComputeErrorByLength(const std::vector<PosePair>& pairs,
                                              const Trajectory& truth, int first_pose_step = 10);

// How far one pose is off.
struct PoseError {
  int64_t timestamp_ns = 0;  // The estimate's.
  Eigen::Vector3d aligned =
      Eigen::Vector3d::Zero();  // The estimated camera centre, beside the truth.
  Rigid3d truth;
  double error_m = 0;
};

// Returns the error of each pair under an alignment, in their order.
std::vector<PoseError> ProfileErrors(const std::vector<PosePair>& pairs,
                                     const Similarity3d& truth_from_estimate);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EVALUATION_TRAJECTORY_ERROR_H_

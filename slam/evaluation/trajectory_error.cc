#include "slam/evaluation/trajectory_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/evaluation/true_travel.h"
#include "slam/util/median.h"

namespace corbslam {
namespace {

constexpr double kSegmentLengths_m[] = {100, 200, 300, 400, 500, 600, 700, 800};
constexpr double kMaxSegmentExcess = 1.1;

Similarity3d Align(const std::vector<PosePair>& pairs, Alignment alignment) {
  Eigen::Matrix3Xd estimate(3, static_cast<Eigen::Index>(pairs.size()));
  Eigen::Matrix3Xd truth(3, static_cast<Eigen::Index>(pairs.size()));
  for (size_t i = 0; i < pairs.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    estimate.col(column) = pairs[i].estimate.world_from_camera.translation;
    truth.col(column) = pairs[i].truth.world_from_camera.translation;
  }
  const Eigen::Matrix4d matrix = Eigen::umeyama(estimate, truth, alignment == Alignment::kSim3);
  Similarity3d truth_from_estimate;
  truth_from_estimate.scale = alignment == Alignment::kSim3 ? matrix.block<3, 1>(0, 0).norm() : 1.0;
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>() / truth_from_estimate.scale;
  truth_from_estimate.rotation = Eigen::Quaterniond(rotation).normalized();
  truth_from_estimate.translation = matrix.topRightCorner<3, 1>();
  return truth_from_estimate;
}

struct Segment {
  size_t last = 0;      // Pair with which it ends.
  double length_m = 0;  // What its error is divided by.
};

// Returns nullopt where the path ends before, or where lost frames leave no pair near the end.
std::optional<Segment> FindSegment(const TrueTravel& travel, size_t first, double nominal_m) {
  const auto end =
      std::upper_bound(travel.at_m.begin(), travel.at_m.end(), travel.at_m[first] + nominal_m);
  if (end == travel.at_m.end()) return std::nullopt;
  const auto last = static_cast<size_t>(end - travel.at_m.begin());
  // Without lost frames, the pose before the last one is within the length.
  const double length_m = std::max(nominal_m, travel.before_m[last] - travel.at_m[first]);
  if (length_m > kMaxSegmentExcess * nominal_m) return std::nullopt;
  return Segment{last, length_m};
}

// Returns the estimate's motion over a segment, seen from the true motion's end.
Rigid3d SegmentError(const PosePair& first, const PosePair& last) {
  const Rigid3d estimated =
      first.estimate.world_from_camera.Inverse() * last.estimate.world_from_camera;
  const Rigid3d actual = first.truth.world_from_camera.Inverse() * last.truth.world_from_camera;
  return estimated.Inverse() * actual;
}

void Add(const Rigid3d& error, const Segment& segment, RelativeError& sum) {
  sum.translation_percent += 100 * error.translation.norm() / segment.length_m;
  sum.rotation_deg_per_100m +=
      RotationAngle(error.rotation) * 180 / std::numbers::pi * 100 / segment.length_m;
  ++sum.segments;
}

// Returns the mean of a sum over at least one segment.
RelativeError Mean(const RelativeError& sum) {
  return {sum.translation_percent / sum.segments, sum.rotation_deg_per_100m / sum.segments,
          sum.segments};
}

}  // namespace

absl::StatusOr<AbsoluteError> ComputeAbsoluteError(const std::vector<PosePair>& pairs,
                                                   Alignment alignment) {
  if (pairs.size() < 3) {
    return absl::FailedPreconditionError(absl::StrCat(
        "an alignment needs at least 3 poses with a true one, there are ", pairs.size()));
  }
  AbsoluteError error;
  error.truth_from_estimate = Align(pairs, alignment);
  if (!std::isfinite(error.truth_from_estimate.scale)) {
    return absl::FailedPreconditionError("the estimate does not move: it has no scale");
  }
  error.poses = pairs.size();
  std::vector<double> distances_m;
  double sum_of_squares = 0;
  for (const PosePair& pair : pairs) {
    const double distance_m =
        (error.truth_from_estimate * pair.estimate.world_from_camera.translation -
         pair.truth.world_from_camera.translation)
            .norm();
    distances_m.push_back(distance_m);
    sum_of_squares += distance_m * distance_m;
    error.mean_m += distance_m;
    error.max_m = std::max(error.max_m, distance_m);
  }
  const auto count = static_cast<double>(pairs.size());
  error.mean_m /= count;
  error.rmse_m = std::sqrt(sum_of_squares / count);
  error.median_m = MeanMedian(std::move(distances_m));
  return error;
}

std::optional<RelativeError> ComputeRelativeError(const std::vector<PosePair>& pairs,
                                                  const Trajectory& truth, int first_pose_step) {
  const TrueTravel travel = MeasureTravel(pairs, truth);
  const auto step = static_cast<size_t>(std::max(first_pose_step, 1));
  RelativeError sum;
  for (size_t first = 0; first < pairs.size(); first += step) {
    for (const double nominal_m : kSegmentLengths_m) {
      const std::optional<Segment> segment = FindSegment(travel, first, nominal_m);
      if (!segment.has_value()) continue;
      Add(SegmentError(pairs[first], pairs[segment->last]), *segment, sum);
    }
  }
  if (sum.segments == 0) return std::nullopt;
  return Mean(sum);
}

std::optional<RelativeError> MeanOverSegments(const std::vector<RelativeError>& errors) {
  RelativeError sum;
  for (const RelativeError& error : errors) {
    sum.translation_percent += error.segments * error.translation_percent;
    sum.rotation_deg_per_100m += error.segments * error.rotation_deg_per_100m;
    sum.segments += error.segments;
  }
  if (sum.segments == 0) return std::nullopt;
  return Mean(sum);
}

std::vector<LengthError> ComputeErrorByLength(const std::vector<PosePair>& pairs,
                                              const Trajectory& truth, int first_pose_step) {
  const TrueTravel travel = MeasureTravel(pairs, truth);
  const auto step = static_cast<size_t>(std::max(first_pose_step, 1));
  std::vector<LengthError> errors;
  for (const double nominal_m : kSegmentLengths_m) {
    RelativeError sum;
    for (size_t first = 0; first < pairs.size(); first += step) {
      const std::optional<Segment> segment = FindSegment(travel, first, nominal_m);
      if (segment.has_value()) Add(SegmentError(pairs[first], pairs[segment->last]), *segment, sum);
    }
    if (sum.segments > 0) errors.push_back({nominal_m, Mean(sum)});
  }
  return errors;
}

std::vector<PoseError> ProfileErrors(const std::vector<PosePair>& pairs,
                                     const Similarity3d& truth_from_estimate) {
  std::vector<PoseError> errors;
  errors.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    PoseError& error = errors.emplace_back();
    error.timestamp_ns = pair.estimate.timestamp_ns;
    error.aligned = truth_from_estimate * pair.estimate.world_from_camera.translation;
    error.truth = pair.truth.world_from_camera;
    error.error_m = (error.aligned - error.truth.translation).norm();
  }
  return errors;
}

}  // namespace corbslam

#include "slam/optimisation/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "slam/optimisation/block_schur_solver.h"
#include "slam/optimisation/bundle_problem.h"
#include "slam/optimisation/ceres_bundle_solver.h"
#include "slam/optimisation/measurement_noise.h"
#include "slam/optimisation/scale_gauge.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// The scope's items in the order of the flat arrays: free ones first. Hash maps are only looked
// up, never iterated.
struct BundleIndex {
  std::vector<const Keyframe*> keyframes;
  std::vector<const MapPoint*> points;
  absl::flat_hash_map<KeyframeId, uint32_t> pose_of;
};

absl::Status AddKeyframes(const Map& map, const std::vector<KeyframeId>& ids, BundleIndex& index) {
  for (const KeyframeId id : ids) {
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("bundle scope: keyframe ", ToString(id), " is not in the map"));
    }
    const auto next = static_cast<uint32_t>(index.keyframes.size());
    if (!index.pose_of.emplace(id, next).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("bundle scope: keyframe ", ToString(id), " is named twice"));
    }
    if (!keyframe->camera_from_map.translation.allFinite() ||
        !keyframe->camera_from_map.rotation.coeffs().allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrCat("bundle scope: pose of keyframe ", ToString(id), " is not finite"));
    }
    index.keyframes.push_back(keyframe);
  }
  return absl::OkStatus();
}

absl::Status AddPoints(const Map& map, const std::vector<MapPointId>& ids, BundleIndex& index) {
  for (const MapPointId id : ids) {
    const MapPoint* point = map.FindPoint(id);
    if (point == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("bundle scope: map point ", ToString(id), " is not in the map"));
    }
    if (!point->position_in_map.allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrCat("bundle scope: position of map point ", ToString(id), " is not finite"));
    }
    index.points.push_back(point);
  }
  return absl::OkStatus();
}

absl::Status CheckNoPointTwice(const BundleScope& scope) {
  std::vector<MapPointId> ids = scope.free_points;
  ids.insert(ids.end(), scope.fixed_points.begin(), scope.fixed_points.end());
  std::sort(ids.begin(), ids.end());
  const auto twice = std::adjacent_find(ids.begin(), ids.end());
  if (twice == ids.end()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("bundle scope: map point ", ToString(*twice), " is named twice"));
}

absl::StatusOr<BundleIndex> MakeIndex(const Map& map, const BundleScope& scope) {
  if (scope.free_keyframes.empty() && scope.free_points.empty()) {
    return absl::InvalidArgumentError("bundle scope: no keyframe and no map point is free");
  }
  if (scope.fixed_keyframes.empty()) {
    return absl::FailedPreconditionError("bundle scope: no keyframe is fixed");
  }
  BundleIndex index;
  index.pose_of.reserve(scope.free_keyframes.size() + scope.fixed_keyframes.size());
  index.points.reserve(scope.free_points.size() + scope.fixed_points.size());
  RETURN_IF_ERROR(AddKeyframes(map, scope.free_keyframes, index));
  RETURN_IF_ERROR(AddKeyframes(map, scope.fixed_keyframes, index));
  RETURN_IF_ERROR(CheckNoPointTwice(scope));
  RETURN_IF_ERROR(AddPoints(map, scope.free_points, index));
  RETURN_IF_ERROR(AddPoints(map, scope.fixed_points, index));
  return index;
}

void AppendObservations(const BundleIndex& index, uint32_t point, uint32_t free_points,
                        BundleProblem& problem) {
  const size_t first = problem.observations.size();
  for (const auto& [keyframe_id, keypoint_index] : index.points[point]->observations) {
    const auto it = index.pose_of.find(keyframe_id);
    if (it == index.pose_of.end()) continue;
    // An observation between fixed items teaches nothing.
    if (point >= free_points && it->second >= problem.free_poses) continue;
    const Keypoint& keypoint = index.keyframes[it->second]->keypoints()[keypoint_index];
    const double disparity_px = problem.poses[it->second].camera->IsMetric()
                                    ? static_cast<double>(keypoint.disparity_px)
                                    : 0;
    problem.observations.push_back({it->second, point,
                                    MakeMeasurement(keypoint.Pixel(), disparity_px,
                                                    ScalePyramid::Variance_px2(keypoint.octave)),
                                    true});
  }
  std::sort(problem.observations.begin() + static_cast<std::ptrdiff_t>(first),
            problem.observations.end(),
            [](const BundleObservation& a, const BundleObservation& b) { return a.pose < b.pose; });
}

BundleProblem MakeProblem(const BundleScope& scope, const BundleIndex& index) {
  BundleProblem problem;
  problem.free_poses = static_cast<uint32_t>(scope.free_keyframes.size());
  problem.free_points = static_cast<uint32_t>(scope.free_points.size());
  for (const Keyframe* keyframe : index.keyframes) {
    problem.poses.push_back({keyframe->camera_from_map.rotation.toRotationMatrix(),
                             keyframe->camera_from_map.translation, &keyframe->camera()});
  }
  problem.points.reserve(index.points.size());
  for (uint32_t p = 0; p < index.points.size(); ++p) {
    problem.points.push_back(index.points[p]->position_in_map);
    AppendObservations(index, p, problem.free_points, problem);
  }
  return problem;
}

bool IsOutlier(const BundleProblem& problem, const BundleObservation& observation,
               double variance = 1) {
  return !(ObservationChi2(problem, observation) <= variance * observation.measured.MaxChi2());
}

// `variances` are those of the poses, in units of the assumed one.
void UseInliersOnly(const std::vector<double>& variances, BundleProblem& problem) {
  for (BundleObservation& o : problem.observations) {
    o.is_used = !IsOutlier(problem, o, variances[o.pose]);
  }
}

using Minimiser = std::function<absl::StatusOr<MinimiseSummary>(const MinimiseOptions&)>;

// The minimiser serves all rounds: the pattern and its analysis are the same.
Minimiser MakeMinimiser(const BundleOptions& options, BundleProblem& problem) {
  if (options.solver == BundleSolver::kCeres) {
    return [&problem](const MinimiseOptions& round) { return MinimiseWithCeres(round, problem); };
  }
  return [solver = std::make_shared<BlockSchurSolver>(options.threads, problem)](
             const MinimiseOptions& round) { return solver->Minimise(round); };
}

void ReadOut(const BundleScope& scope, const BundleIndex& index, const BundleProblem& problem,
             BundleResult& result) {
  for (uint32_t i = 0; i < problem.free_poses; ++i) {
    const BundlePose& pose = problem.poses[i];
    result.poses.push_back(
        {scope.free_keyframes[i], {Eigen::Quaterniond(pose.R).normalized(), pose.t}});
  }
  // Number of coordinates by which the observations that stay measure each point.
  std::vector<int> coordinates(problem.points.size(), 0);
  for (const BundleObservation& o : problem.observations) {
    if (IsOutlier(problem, o)) {
      result.outliers.push_back({index.points[o.point]->id, index.keyframes[o.pose]->id()});
    } else {
      coordinates[o.point] += o.measured.has_depth ? 3 : 2;
    }
  }
  std::sort(result.outliers.begin(), result.outliers.end());
  for (uint32_t p = 0; p < problem.free_points; ++p) {
    if (coordinates[p] >= 3) result.positions.push_back({scope.free_points[p], problem.points[p]});
  }
}

}  // namespace

absl::StatusOr<BundleResult> AdjustBundle(const Map& map, const BundleScope& scope,
                                          const BundleOptions& options) {
  ASSIGN_OR_RETURN(const BundleIndex index, MakeIndex(map, scope));
  BundleProblem problem = MakeProblem(scope, index);
  if (problem.observations.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("bundle scope: none of its ", index.points.size(),
                     " map points is seen by any of its ", index.keyframes.size(), " keyframes"));
  }
  const ScaleGauge gauge(problem);
  const Minimiser minimiser = MakeMinimiser(options, problem);
  std::vector<double> variances(problem.poses.size(), 1);
  BundleResult result;
  const int rounds = std::max(options.outlier_rounds, 0) + 1;
  for (int round = 0; round < rounds && !result.cancelled; ++round) {
    MinimiseOptions minimise;
    minimise.max_iterations = options.max_iterations;
    minimise.robust = options.use_robust_loss && round == 0;
    minimise.threads = options.threads;
    minimise.converged_cost_change =
        round + 1 < rounds ? options.outlier_round_cost_change : options.converged_cost_change;
    if (options.keep_going) {
      minimise.keep_going = [&](int iteration) {
        const double part = static_cast<double>(iteration) / std::max(options.max_iterations, 1);
        return options.keep_going((round + std::min(part, 1.0)) / rounds);
      };
    }
    ASSIGN_OR_RETURN(const MinimiseSummary summary, minimiser(minimise));
    if (round == 0) result.initial_cost = summary.initial_cost;
    result.final_cost = summary.final_cost;
    result.iterations += summary.iterations;
    result.cancelled = summary.cancelled;
    if (round + 1 == rounds) break;
    if (options.measure_noise && round == 0) variances = MeasureNoise(problem);
    UseInliersOnly(variances, problem);
  }
  gauge.Hold(problem);
  ReadOut(scope, index, problem, result);
  return result;
}

void ApplyBundle(const BundleResult& result, Map& map) {
  for (const PoseUpdate& update : result.poses) map.SetPose(update.id, update.camera_from_map);
  for (const ObservationKey& key : result.outliers) map.RemoveObservation(key.point, key.keyframe);
  for (const PositionUpdate& update : result.positions) {
    map.SetPosition(update.id, update.position_in_map);
    map.UpdatePointGeometry(update.id);
  }
}

}  // namespace corbslam

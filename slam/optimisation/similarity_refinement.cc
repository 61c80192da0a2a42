#include "slam/optimisation/similarity_refinement.h"

#include <ceres/ceres.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "slam/optimisation/mutual_reprojection_cost.h"
#include "slam/optimisation/similarity_manifold.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

constexpr int kMinMatches = 3;
constexpr int kRobustIterations = 8;
constexpr int kFinalIterations = 10;

double PixelChi2(const Camera& camera, const Eigen::Vector3d& x_in_camera,
                 const Eigen::Vector2d& pixel, double variance_px2) {
  if (!(x_in_camera.z() > kMinDepth)) return std::numeric_limits<double>::infinity();
  return (Project(camera, x_in_camera) - pixel).squaredNorm() / variance_px2;
}

struct Refinement {
  const Camera& camera_a;
  const Camera& camera_b;
  absl::Span<const SimilarityMatch> matches;
  absl::Span<const SimilaritySight> sights;
  double max_chi2;
};

// What is made of it: beside the result, the sights that count.
struct State {
  SimilarityRefinement refined;
  std::vector<const SimilaritySight*> sights = {};
};

bool Fits(const SimilarityMatch& match, const SimilaritySight& sight, const Similarity3d& b_from_a,
          double max_chi2) {
  const Eigen::Vector3d x_in_side =
      sight.is_of_b ? b_from_a * match.x_in_a : b_from_a.Inverse() * match.x_in_b;
  const double chi2 =
      PixelChi2(*sight.camera, sight.camera_from_side * x_in_side, sight.pixel, sight.variance_px2);
  return std::isfinite(chi2) && chi2 <= max_chi2;
}

void ChooseSights(const Refinement& input, double max_chi2, State& state) {
  state.sights.clear();
  for (const SimilaritySight& sight : input.sights) {
    if (!state.refined.is_inlier[sight.match]) continue;
    if (Fits(input.matches[sight.match], sight, state.refined.b_from_a, max_chi2)) {
      state.sights.push_back(&sight);
    }
  }
}

// Marks the inliers. An infinite `max_chi2` makes inliers of all that lies in front of both
// cameras.
void Classify(const Refinement& input, double max_chi2, State& state) {
  SimilarityRefinement& refined = state.refined;
  refined.is_inlier.assign(input.matches.size(), 0);
  refined.inliers = 0;
  for (size_t i = 0; i < input.matches.size(); ++i) {
    const SimilarityErrors errors =
        ReprojectionErrors(input.camera_a, input.camera_b, refined.b_from_a, input.matches[i]);
    if (!std::isfinite(errors.in_a) || !std::isfinite(errors.in_b)) continue;
    if (errors.in_a > max_chi2 || errors.in_b > max_chi2) continue;
    refined.is_inlier[i] = 1;
    ++refined.inliers;
  }
  ChooseSights(input, max_chi2, state);
}

absl::Status CheckEnough(const SimilarityRefinement& state) {
  if (state.inliers >= kMinMatches) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("similarity refinement: ", state.inliers,
                                                    " of ", state.is_inlier.size(),
                                                    " matches fit, need ", kMinMatches));
}

absl::Status CheckSights(absl::Span<const SimilaritySight> sights, size_t matches) {
  for (size_t i = 0; i < sights.size(); ++i) {
    const SimilaritySight& sight = sights[i];
    if (sight.match < matches && sight.camera != nullptr && sight.pixel.allFinite() &&
        sight.variance_px2 > 0) {
      continue;
    }
    return absl::InvalidArgumentError(
        absl::StrCat("similarity refinement: sight ", i, " is of match ", sight.match, " of ",
                     matches, ", without a camera, not finite or has a variance of 0"));
  }
  return absl::OkStatus();
}

absl::Status CheckInput(absl::Span<const SimilarityMatch> matches, const Similarity3d& initial) {
  if (matches.size() < kMinMatches) {
    return absl::InvalidArgumentError(
        absl::StrCat("similarity refinement: ", matches.size(), " matches, need ", kMinMatches));
  }
  for (size_t i = 0; i < matches.size(); ++i) {
    const SimilarityMatch& m = matches[i];
    const bool is_finite = m.x_in_a.allFinite() && m.x_in_b.allFinite() &&
                           m.pixel_in_a.allFinite() && m.pixel_in_b.allFinite();
    if (!is_finite || !(m.variance_a_px2 > 0) || !(m.variance_b_px2 > 0)) {
      return absl::InvalidArgumentError(absl::StrCat("similarity refinement: match ", i,
                                                     " is not finite or has a variance of 0"));
    }
  }
  if (!(initial.scale > 0) || !initial.translation.allFinite() ||
      !initial.rotation.coeffs().allFinite()) {
    return absl::InvalidArgumentError("similarity refinement: initial value is not finite");
  }
  return absl::OkStatus();
}

void AddMatches(const Refinement& input, const State& state, ceres::LossFunction* loss,
                double* block, ceres::Problem& problem) {
  for (size_t i = 0; i < input.matches.size(); ++i) {
    if (!state.refined.is_inlier[i]) continue;
    const SimilarityMatch& m = input.matches[i];
    problem.AddResidualBlock(
        new MutualReprojectionCost<false>(input.camera_b, m.x_in_a, m.pixel_in_b, m.variance_b_px2),
        loss, block);
    problem.AddResidualBlock(
        new MutualReprojectionCost<true>(input.camera_a, m.x_in_b, m.pixel_in_a, m.variance_a_px2),
        loss, block);
  }
}

void AddSights(const Refinement& input, const State& state, ceres::LossFunction* loss,
               double* block, ceres::Problem& problem) {
  absl::flat_hash_map<std::pair<size_t, bool>, int> beside;
  for (const SimilaritySight* sight : state.sights) ++beside[{sight->match, sight->is_of_b}];
  for (const SimilaritySight* sight : state.sights) {
    const SimilarityMatch& m = input.matches[sight->match];
    const double variance_px2 = sight->variance_px2 * beside.at({sight->match, sight->is_of_b});
    ceres::CostFunction* cost = nullptr;
    if (sight->is_of_b) {
      cost = new MutualReprojectionCost<false>(*sight->camera, m.x_in_a, sight->pixel, variance_px2,
                                               sight->camera_from_side);
    } else {
      cost = new MutualReprojectionCost<true>(*sight->camera, m.x_in_b, sight->pixel, variance_px2,
                                              sight->camera_from_side);
    }
    problem.AddResidualBlock(cost, loss, block);
  }
}

void SetManifold(bool fix_scale, SimilarityBlock& block, ceres::Problem& problem) {
  if (fix_scale) {
    problem.SetManifold(block.data(), new LeftPerturbation<6>());
  } else {
    problem.SetManifold(block.data(), new LeftPerturbation<7>());
  }
}

absl::Status Minimise(const Refinement& input, bool robust, bool fix_scale, int iterations,
                      State& state) {
  SimilarityBlock block = ToBlock(state.refined.b_from_a);
  ceres::Problem problem;
  ceres::LossFunction* const loss =
      robust ? new ceres::HuberLoss(std::sqrt(input.max_chi2)) : nullptr;
  AddMatches(input, state, loss, block.data(), problem);
  AddSights(input, state, loss, block.data(), problem);
  SetManifold(fix_scale, block, problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = iterations;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    return absl::InternalError(absl::StrCat("similarity refinement: ", summary.message));
  }
  state.refined.b_from_a = FromBlock(block.data());
  return absl::OkStatus();
}

}  // namespace

SimilarityErrors ReprojectionErrors(const Camera& camera_a, const Camera& camera_b,
                                    const Similarity3d& b_from_a, const SimilarityMatch& match) {
  return {PixelChi2(camera_a, b_from_a.Inverse() * match.x_in_b, match.pixel_in_a,
                    match.variance_a_px2),
          PixelChi2(camera_b, b_from_a * match.x_in_a, match.pixel_in_b, match.variance_b_px2)};
}

absl::StatusOr<SimilarityRefinement> RefineSimilarity(const Camera& camera_a,
                                                      const Camera& camera_b,
                                                      absl::Span<const SimilarityMatch> matches,
                                                      const Similarity3d& initial_b_from_a,
                                                      bool fix_scale, double max_chi2,
                                                      absl::Span<const SimilaritySight> sights) {
  RETURN_IF_ERROR(CheckInput(matches, initial_b_from_a));
  RETURN_IF_ERROR(CheckSights(sights, matches.size()));
  const Refinement input{camera_a, camera_b, matches, sights, max_chi2};
  State state;
  state.refined.b_from_a = initial_b_from_a;
  state.refined.b_from_a.rotation.normalize();
  Classify(input, std::numeric_limits<double>::infinity(), state);
  RETURN_IF_ERROR(CheckEnough(state.refined));
  RETURN_IF_ERROR(Minimise(input, true, fix_scale, kRobustIterations, state));
  Classify(input, max_chi2, state);
  RETURN_IF_ERROR(CheckEnough(state.refined));
  RETURN_IF_ERROR(Minimise(input, false, fix_scale, kFinalIterations, state));
  Classify(input, max_chi2, state);
  RETURN_IF_ERROR(CheckEnough(state.refined));
  return state.refined;
}

absl::StatusOr<Matrix7d> SimilarityCovariance(const Camera& camera_a, const Camera& camera_b,
                                              absl::Span<const SimilarityMatch> matches,
                                              const SimilarityRefinement& refined, bool fix_scale,
                                              absl::Span<const SimilaritySight> sights) {
  RETURN_IF_ERROR(CheckSights(sights, matches.size()));
  SimilarityBlock block = ToBlock(refined.b_from_a);
  ceres::Problem problem;
  const Refinement input{camera_a, camera_b, matches, sights, kMaxChi2OfSimilarity};
  State state{refined};
  ChooseSights(input, input.max_chi2, state);
  AddMatches(input, state, nullptr, block.data(), problem);
  AddSights(input, state, nullptr, block.data(), problem);
  if (!problem.HasParameterBlock(block.data())) {
    return absl::FailedPreconditionError("similarity covariance: no match is an inlier");
  }
  SetManifold(fix_scale, block, problem);
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.num_threads = 1;
  ceres::Covariance covariance(options);
  const std::vector<const double*> blocks = {block.data()};
  if (!covariance.Compute(blocks, &problem)) {
    return absl::FailedPreconditionError(absl::StrCat("similarity covariance: ", refined.inliers,
                                                      " inliers leave a direction open"));
  }
  const int size = fix_scale ? 6 : 7;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> tangent(size, size);
  covariance.GetCovarianceMatrixInTangentSpace(blocks, tangent.data());
  Matrix7d result = Matrix7d::Zero();
  result.topLeftCorner(size, size) = tangent;
  return result;
}

}  // namespace corbslam

#include "slam/optimisation/ceres_bundle_solver.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/optimisation/pose_manifold.h"
#include "slam/optimisation/reprojection_cost.h"

namespace corbslam {
namespace {

// The reduced system of so many poses is solved faster densely.
constexpr uint32_t kMaxDensePoses = 80;

ceres::Problem::Options NothingOwned() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

class BundleLoss : public ceres::LossFunction {
 public:
  BundleLoss(double max_chi2, bool robust) : max_chi2_(max_chi2), robust_(robust) {}

  void Evaluate(double chi2, double rho[3]) const override {
    const RobustCost loss = ObservationLoss(chi2, max_chi2_, robust_);
    rho[0] = loss.cost;
    rho[1] = loss.weight;
    rho[2] = loss.weight < 1 ? -loss.weight / (2 * chi2) : 0;
  }

 private:
  const double max_chi2_;
  const bool robust_;
};

// A ceres::Problem over copies of a BundleProblem's values, with all that it points to.
class CeresProblem {
 public:
  CeresProblem(const BundleProblem& source, bool robust)
      : points_(source.points),
        mono_loss_(kChi2Mono, robust),
        stereo_loss_(kChi2Stereo, robust),
        problem_(NothingOwned()) {
    poses_.reserve(source.poses.size());
    for (const BundlePose& pose : source.poses) {
      poses_.push_back(ToPoseBlock(Eigen::Quaterniond(pose.R).normalized(), pose.t));
    }
    for (const BundleObservation& o : source.observations) {
      if (o.is_used) AddObservation(*source.poses[o.pose].camera, o);
    }
    for (uint32_t i = 0; i < poses_.size(); ++i) {
      AddBlock(poses_[i].data(), 1, i < source.free_poses);
    }
    for (uint32_t p = 0; p < points_.size(); ++p) {
      AddBlock(points_[p].data(), 0, p < source.free_points);
    }
  }

  ceres::Problem& problem() { return problem_; }
  // Points are eliminated first, then poses.
  std::shared_ptr<ceres::ParameterBlockOrdering> elimination_order() const { return order_; }

  void CopyTo(BundleProblem& target) const {
    for (uint32_t i = 0; i < target.free_poses; ++i) {
      const double* block = poses_[i].data();
      if (!problem_.HasParameterBlock(block)) continue;
      const Eigen::Quaterniond rotation{Eigen::Map<const Eigen::Vector4d>(block)};
      target.poses[i].R = rotation.normalized().toRotationMatrix();
      target.poses[i].t = Eigen::Map<const Eigen::Vector3d>(block + 4);
    }
    std::copy_n(points_.begin(), target.free_points, target.points.begin());
  }

 private:
  void AddObservation(const Camera& camera, const BundleObservation& o) {
    ceres::CostFunction* cost = nullptr;
    ceres::LossFunction* loss = nullptr;
    if (o.measured.has_depth) {
      cost = &stereo_costs_.emplace_back(camera, o.measured);
      loss = &stereo_loss_;
    } else {
      cost = &mono_costs_.emplace_back(camera, o.measured);
      loss = &mono_loss_;
    }
    problem_.AddResidualBlock(cost, loss, poses_[o.pose].data(), points_[o.point].data());
  }

  void AddBlock(double* block, int group, bool is_free) {
    if (!problem_.HasParameterBlock(block)) return;
    if (group == 1) problem_.SetManifold(block, &manifold_);
    if (!is_free) problem_.SetParameterBlockConstant(block);
    order_->AddElementToGroup(block, group);
  }

  std::vector<PoseBlock> poses_;
  std::vector<Eigen::Vector3d> points_;
  std::deque<MonoReprojectionCost> mono_costs_;
  std::deque<StereoReprojectionCost> stereo_costs_;
  BundleLoss mono_loss_;
  BundleLoss stereo_loss_;
  PoseManifold manifold_;
  std::shared_ptr<ceres::ParameterBlockOrdering> order_ =
      std::make_shared<ceres::ParameterBlockOrdering>();
  // The last member: it goes before what it points to.
  ceres::Problem problem_;
};

class KeepGoing : public ceres::IterationCallback {
 public:
  explicit KeepGoing(const std::function<bool(int)>& keep_going) : keep_going_(keep_going) {}

  bool was_refused() const { return was_refused_; }

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    // Number 0 is the first evaluation.
    was_refused_ = summary.iteration > 0 && !keep_going_(summary.iteration);
    // "Abort" would throw away what was reached.
    return was_refused_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::function<bool(int)>& keep_going_;
  bool was_refused_ = false;
};

ceres::Solver::Options SolverOptions(const MinimiseOptions& options, uint32_t free_poses) {
  ceres::Solver::Options solver;
  solver.linear_solver_type =
      free_poses <= kMaxDensePoses ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  // LAPACK's speed and threads depend on what is installed, Eigen's don't.
  solver.dense_linear_algebra_library_type = ceres::EIGEN;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = std::max(options.threads, 1);
  solver.function_tolerance = options.converged_cost_change;
  solver.parameter_tolerance = 0;
  // The problem begins near the minimum: the first step is nearly Gauss and Newton's.
  solver.initial_trust_region_radius = 1e5;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace

absl::StatusOr<MinimiseSummary> MinimiseWithCeres(const MinimiseOptions& options,
                                                  BundleProblem& problem) {
  CeresProblem copy(problem, options.robust);
  if (copy.problem().NumResidualBlocks() == 0) return MinimiseSummary{};
  ceres::Solver::Options solver = SolverOptions(options, problem.free_poses);
  solver.linear_solver_ordering = copy.elimination_order();
  KeepGoing callback(options.keep_going);
  if (options.keep_going) solver.callbacks.push_back(&callback);
  ceres::Solver::Summary solved;
  ceres::Solve(solver, &copy.problem(), &solved);
  if (!solved.IsSolutionUsable()) {
    return absl::InternalError(absl::StrCat("bundle adjustment by Ceres: ", solved.message));
  }
  copy.CopyTo(problem);
  MinimiseSummary summary;
  summary.iterations = solved.num_successful_steps + solved.num_unsuccessful_steps;
  summary.initial_cost = solved.initial_cost;
  summary.final_cost = solved.final_cost;
  summary.cancelled = callback.was_refused();
  return summary;
}

}  // namespace corbslam

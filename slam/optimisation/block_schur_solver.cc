#include "slam/optimisation/block_schur_solver.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <thread>
#include <utility>

#include "slam/optimisation/reduced_camera_system.h"

namespace corbslam {
namespace {

using Matrix63d = Eigen::Matrix<double, 6, 3>;

constexpr double kInitialDamping = 1e-5;
constexpr double kMaxDamping = 1e8;
constexpr double kMinDamping = 1e-12;
constexpr double kMinDiagonal = 1e-9;
constexpr double kUnseen = std::numeric_limits<double>::infinity();

// Sums over one thread's share of the points.
struct PoseSums {
  std::vector<Matrix6d> blocks;
  Eigen::VectorXd right_side;
  double cost = 0;
};

}  // namespace

class BlockSchurSolver::Equations {
 public:
  Equations(int threads, BundleProblem& problem);
  MinimiseSummary Minimise(const MinimiseOptions& options);

 private:
  struct PointSystem {
    Eigen::Matrix3d H;
    Eigen::Vector3d b;
    Eigen::Matrix3d inverse;
  };

  void GroupByPoint();
  template <typename Function>
  void ForEachShare(const Function& function);

  double Linearise();
  void LinearisePoint(uint32_t point, PoseSums& sums);
  bool SolveStep(double damping);
  void EliminatePoint(uint32_t point, double damping, PoseSums& sums);
  void MakeCandidate();
  double CandidateCost();
  double PredictedDecrease(double damping) const;

  bool robust_ = true;  // True in a minimisation with the robust loss.
  BundleProblem& problem_;
  size_t shares_;
  std::vector<uint32_t> begin_;       // Point p has the observations [begin_[p], begin_[p + 1]).
  std::vector<uint32_t> pair_begin_;  // First pair of each point in pair_blocks_.
  ReducedCameraSystem system_;
  std::vector<uint32_t> pair_blocks_;
  std::vector<uint32_t> diagonal_;

  std::vector<Matrix6d> pose_H_;
  Eigen::VectorXd pose_b_;
  std::vector<PointSystem> point_systems_;
  std::vector<Matrix63d> couplings_;  // J_pose^T * weight * J_point of each observation.
  std::vector<PoseSums> sums_;        // The sums of each share.

  Eigen::VectorXd pose_step_;
  std::vector<Eigen::Vector3d> point_step_;
  std::vector<BundlePose> candidate_poses_;
  std::vector<Eigen::Vector3d> candidate_points_;
};

namespace {

// An observation of a free pose counts even when it is not used, with a coupling of zero: it may be
// used another time, and the pattern stays.
bool IsFree(const BundleProblem& problem, const BundleObservation& o) {
  return o.pose < problem.free_poses;
}

std::vector<uint32_t> BeginOfPoints(const BundleProblem& problem) {
  std::vector<uint32_t> begin(problem.points.size() + 1, 0);
  for (const BundleObservation& o : problem.observations) ++begin[o.point + 1];
  for (size_t p = 0; p < problem.points.size(); ++p) begin[p + 1] += begin[p];
  return begin;
}

// Lists the observations of free points by each free pose: those of pose i are those from begin[i]
// on.
struct ObservationsOfPoses {
  std::vector<uint32_t> begin;
  std::vector<uint32_t> observations;
};

ObservationsOfPoses GroupByPose(const BundleProblem& problem, uint32_t end) {
  ObservationsOfPoses group;
  group.begin.assign(problem.free_poses + 1, 0);
  for (uint32_t i = 0; i < end; ++i) {
    if (IsFree(problem, problem.observations[i])) ++group.begin[problem.observations[i].pose + 1];
  }
  std::partial_sum(group.begin.begin(), group.begin.end(), group.begin.begin());
  group.observations.resize(group.begin.back());
  std::vector<uint32_t> next(group.begin.begin(), group.begin.end() - 1);
  for (uint32_t i = 0; i < end; ++i) {
    if (!IsFree(problem, problem.observations[i])) continue;
    group.observations[next[problem.observations[i].pose]++] = i;
  }
  return group;
}

// Returns the pairs of free poses that see a free point together, and each pose with itself: column
// by column, in each its rows from the diagonal on. It costs what they see together, not the poses
// squared.
std::vector<std::pair<uint32_t, uint32_t>> PosePairs(const BundleProblem& problem,
                                                     const std::vector<uint32_t>& begin) {
  const auto n = static_cast<uint32_t>(problem.free_poses);
  const ObservationsOfPoses of_poses = GroupByPose(problem, begin[problem.free_points]);
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  std::vector<char> is_row(n, 0);
  std::vector<uint32_t> rows;
  for (uint32_t column = 0; column < n; ++column) {
    rows.assign(1, column);
    for (uint32_t k = of_poses.begin[column]; k < of_poses.begin[column + 1]; ++k) {
      const uint32_t point = problem.observations[of_poses.observations[k]].point;
      for (uint32_t i = begin[point]; i < begin[point + 1]; ++i) {
        const BundleObservation& other = problem.observations[i];
        if (!IsFree(problem, other) || other.pose <= column || is_row[other.pose]) continue;
        is_row[other.pose] = 1;
        rows.push_back(other.pose);
      }
    }
    std::ranges::sort(rows);
    for (const uint32_t row : rows) {
      pairs.emplace_back(column, row);
      is_row[row] = 0;
    }
  }
  return pairs;
}

}  // namespace

BlockSchurSolver::Equations::Equations(int threads, BundleProblem& problem)
    : problem_(problem),
      shares_(static_cast<size_t>(std::max(threads, 1))),
      begin_(BeginOfPoints(problem)),
      system_(problem.free_poses, PosePairs(problem, begin_)),
      point_systems_(problem.free_points),
      couplings_(problem.observations.size()),
      sums_(shares_),
      point_step_(problem.free_points) {
  GroupByPoint();
}

// Remembers for each pair of poses of each point which block it adds to.
void BlockSchurSolver::Equations::GroupByPoint() {
  for (uint32_t pose = 0; pose < problem_.free_poses; ++pose) {
    diagonal_.push_back(system_.BlockIndex(pose, pose));
  }
  pair_begin_.push_back(0);
  for (uint32_t p = 0; p < problem_.free_points; ++p) {
    for (uint32_t i = begin_[p]; i < begin_[p + 1]; ++i) {
      if (!IsFree(problem_, problem_.observations[i])) continue;
      for (uint32_t j = begin_[p]; j <= i; ++j) {
        if (!IsFree(problem_, problem_.observations[j])) continue;
        pair_blocks_.push_back(
            system_.BlockIndex(problem_.observations[i].pose, problem_.observations[j].pose));
      }
    }
    pair_begin_.push_back(static_cast<uint32_t>(pair_blocks_.size()));
  }
}

// Calls function(share, first point, end point) for contiguous shares with about the same number
// of observations, one a thread.
template <typename Function>
void BlockSchurSolver::Equations::ForEachShare(const Function& function) {
  std::vector<uint32_t> bounds = {0};
  const auto points = static_cast<uint32_t>(problem_.points.size());
  for (size_t s = 1; s < shares_; ++s) {
    const auto target = static_cast<uint32_t>(problem_.observations.size() * s / shares_);
    const auto it = std::lower_bound(begin_.begin(), begin_.end(), target);
    bounds.push_back(std::min(static_cast<uint32_t>(it - begin_.begin()), points));
  }
  bounds.push_back(points);
  std::vector<std::jthread> threads;
  for (size_t s = 1; s < shares_; ++s) {
    threads.emplace_back([&, s] { function(s, bounds[s], bounds[s + 1]); });
  }
  function(0, bounds[0], bounds[1]);
}

void BlockSchurSolver::Equations::LinearisePoint(uint32_t point, PoseSums& sums) {
  const bool is_free_point = point < problem_.free_points;
  PointSystem system{Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  for (uint32_t i = begin_[point]; i < begin_[point + 1]; ++i) {
    const BundleObservation& o = problem_.observations[i];
    couplings_[i].setZero();
    if (!o.is_used) continue;
    const BundlePose& pose = problem_.poses[o.pose];
    const Eigen::Vector3d x = pose.ToCamera(problem_.points[point]);
    const double max_chi2 = o.measured.MaxChi2();
    if (!(x.z() > kMinDepth)) {
      sums.cost += ObservationLoss(kUnseen, max_chi2, robust_).cost;
      continue;
    }
    const Eigen::Vector3d r = ReprojectionResidual(*pose.camera, x, o.measured);
    const double chi2 = r.squaredNorm() * o.measured.inverse_variance;
    const RobustCost loss = ObservationLoss(chi2, max_chi2, robust_);
    sums.cost += loss.cost;
    if (loss.weight == 0) continue;
    const double weight = loss.weight * o.measured.inverse_variance;
    const Eigen::Matrix3d J_x = ReprojectionJacobian(*pose.camera, x, o.measured.has_depth);
    const Eigen::Matrix3d J_point = J_x * pose.R;
    if (is_free_point) {
      system.H.noalias() += weight * J_point.transpose() * J_point;
      system.b.noalias() += weight * J_point.transpose() * r;
    }
    if (o.pose >= problem_.free_poses) continue;
    const Eigen::Matrix<double, 3, 6> J_pose = PoseJacobian(J_x, x);
    const Matrix63d weighted = weight * J_pose.transpose();
    sums.blocks[o.pose].noalias() += weighted.lazyProduct(J_pose);
    sums.right_side.segment<6>(6 * o.pose).noalias() += weighted * r;
    if (is_free_point) couplings_[i].noalias() = weighted * J_point;
  }
  if (is_free_point) point_systems_[point] = system;
}

// Fills the undamped normal equations; returns the cost.
double BlockSchurSolver::Equations::Linearise() {
  ForEachShare([this](size_t share, uint32_t first, uint32_t end) {
    PoseSums& sums = sums_[share];
    sums.blocks.assign(problem_.free_poses, Matrix6d::Zero());
    sums.right_side.setZero(6 * problem_.free_poses);
    sums.cost = 0;
    for (uint32_t p = first; p < end; ++p) LinearisePoint(p, sums);
  });
  pose_H_ = sums_[0].blocks;
  pose_b_ = sums_[0].right_side;
  double cost = sums_[0].cost;
  for (size_t s = 1; s < shares_; ++s) {
    for (size_t i = 0; i < pose_H_.size(); ++i) pose_H_[i] += sums_[s].blocks[i];
    pose_b_ += sums_[s].right_side;
    cost += sums_[s].cost;
  }
  return cost / 2;
}

template <typename Matrix>
Matrix Damped(const Matrix& H, double damping) {
  Matrix damped = H;
  damped.diagonal() += damping * H.diagonal();
  damped.diagonal().array() += kMinDiagonal;
  return damped;
}

void BlockSchurSolver::Equations::EliminatePoint(uint32_t point, double damping, PoseSums& sums) {
  PointSystem& system = point_systems_[point];
  system.inverse = Damped(system.H, damping).inverse();
  const Eigen::Vector3d point_part = system.inverse * system.b;
  uint32_t pair = pair_begin_[point];
  for (uint32_t i = begin_[point]; i < begin_[point + 1]; ++i) {
    const BundleObservation& row = problem_.observations[i];
    if (!IsFree(problem_, row)) continue;
    sums.right_side.segment<6>(6 * row.pose).noalias() += couplings_[i] * point_part;
    const Matrix63d W_inverse = couplings_[i] * system.inverse;
    for (uint32_t j = begin_[point]; j <= i; ++j) {
      if (!IsFree(problem_, problem_.observations[j])) continue;
      sums.blocks[pair_blocks_[pair++]].noalias() -=
          W_inverse.lazyProduct(couplings_[j].transpose());
    }
  }
}

// Computes the step of poses and points for the damped equations.
bool BlockSchurSolver::Equations::SolveStep(double damping) {
  ForEachShare([&](size_t share, uint32_t first, uint32_t end) {
    PoseSums& sums = sums_[share];
    sums.blocks.assign(system_.blocks(), Matrix6d::Zero());
    sums.right_side.setZero(6 * problem_.free_poses);
    for (uint32_t p = first; p < std::min(end, problem_.free_points); ++p) {
      EliminatePoint(p, damping, sums);
    }
  });
  PoseSums& total = sums_[0];
  for (size_t s = 1; s < shares_; ++s) {
    for (size_t i = 0; i < total.blocks.size(); ++i) total.blocks[i] += sums_[s].blocks[i];
    total.right_side += sums_[s].right_side;
  }
  for (size_t i = 0; i < pose_H_.size(); ++i) {
    total.blocks[diagonal_[i]] += Damped(pose_H_[i], damping);
  }
  total.right_side -= pose_b_;
  if (!system_.Solve(total.blocks, total.right_side, pose_step_)) return false;
  for (uint32_t p = 0; p < problem_.free_points; ++p) {
    Eigen::Vector3d right_side = -point_systems_[p].b;
    for (uint32_t i = begin_[p]; i < begin_[p + 1]; ++i) {
      const BundleObservation& o = problem_.observations[i];
      if (!IsFree(problem_, o)) continue;
      right_side.noalias() -= couplings_[i].transpose() * pose_step_.segment<6>(6 * o.pose);
    }
    point_step_[p] = point_systems_[p].inverse * right_side;
  }
  return true;
}

void BlockSchurSolver::Equations::MakeCandidate() {
  candidate_poses_ = problem_.poses;
  candidate_points_ = problem_.points;
  for (uint32_t i = 0; i < problem_.free_poses; ++i) {
    const Eigen::Matrix3d R = ExpSO3(pose_step_.segment<3>(6 * i + 3)).toRotationMatrix();
    BundlePose& pose = candidate_poses_[i];
    pose.R = R * pose.R;
    pose.t = R * pose.t + pose_step_.segment<3>(6 * i);
  }
  for (uint32_t p = 0; p < problem_.free_points; ++p) candidate_points_[p] += point_step_[p];
}

double ObservationCost(const BundlePose& pose, const Eigen::Vector3d& x_in_map,
                       const PixelMeasurement& measured, bool robust) {
  const Eigen::Vector3d x = pose.ToCamera(x_in_map);
  const double chi2 = x.z() > kMinDepth
                          ? ReprojectionResidual(*pose.camera, x, measured).squaredNorm() *
                                measured.inverse_variance
                          : kUnseen;
  return ObservationLoss(chi2, measured.MaxChi2(), robust).cost;
}

double BlockSchurSolver::Equations::CandidateCost() {
  ForEachShare([this](size_t share, uint32_t first, uint32_t end) {
    double cost = 0;
    for (uint32_t i = begin_[first]; i < begin_[end]; ++i) {
      const BundleObservation& o = problem_.observations[i];
      if (!o.is_used) continue;
      cost += ObservationCost(candidate_poses_[o.pose], candidate_points_[o.point], o.measured,
                              robust_);
    }
    sums_[share].cost = cost;
  });
  double cost = 0;
  for (const PoseSums& sums : sums_) cost += sums.cost;
  return cost / 2;
}

// Returns what the damped quadratic model promises: step^T (damping D step - b) / 2.
double BlockSchurSolver::Equations::PredictedDecrease(double damping) const {
  double sum = 0;
  for (size_t i = 0; i < pose_H_.size(); ++i) {
    const Vector6d step = pose_step_.segment<6>(static_cast<Eigen::Index>(6 * i));
    const Vector6d b = pose_b_.segment<6>(static_cast<Eigen::Index>(6 * i));
    sum += step.dot(damping * pose_H_[i].diagonal().cwiseProduct(step) - b);
  }
  for (size_t p = 0; p < point_systems_.size(); ++p) {
    const Eigen::Vector3d& step = point_step_[p];
    sum +=
        step.dot(damping * point_systems_[p].H.diagonal().cwiseProduct(step) - point_systems_[p].b);
  }
  return sum / 2;
}

// The damping follows Nielsen, "Damping Parameter in Marquardt's Method", 1999.
MinimiseSummary BlockSchurSolver::Equations::Minimise(const MinimiseOptions& options) {
  robust_ = options.robust;
  MinimiseSummary summary;
  double cost = summary.initial_cost = Linearise();
  double damping = kInitialDamping;
  double growth = 2;
  while (summary.iterations < options.max_iterations && damping < kMaxDamping) {
    ++summary.iterations;
    double next_cost = std::numeric_limits<double>::infinity();
    if (SolveStep(damping)) {
      MakeCandidate();
      next_cost = CandidateCost();
    }
    const double decrease = cost - next_cost;
    const bool is_better = decrease > 0 && std::isfinite(next_cost);
    if (is_better) {
      const double gain = decrease / std::max(PredictedDecrease(damping), 1e-300);
      std::swap(problem_.poses, candidate_poses_);
      std::swap(problem_.points, candidate_points_);
      damping = std::max(damping * std::max(1.0 / 3, 1 - std::pow(2 * gain - 1, 3)), kMinDamping);
      growth = 2;
    } else {
      damping *= growth;
      growth *= 2;
    }
    if (options.keep_going && !options.keep_going(summary.iterations)) summary.cancelled = true;
    const bool has_converged = std::abs(decrease) <= options.converged_cost_change * cost;
    if (is_better) cost = next_cost;
    if (summary.cancelled || has_converged) break;
    if (is_better && summary.iterations < options.max_iterations) Linearise();
  }
  summary.final_cost = cost;
  return summary;
}

BlockSchurSolver::BlockSchurSolver(int threads, BundleProblem& problem)
    : equations_(std::make_unique<Equations>(threads, problem)) {}

BlockSchurSolver::~BlockSchurSolver() = default;

MinimiseSummary BlockSchurSolver::Minimise(const MinimiseOptions& options) {
  return equations_->Minimise(options);
}

}  // namespace corbslam

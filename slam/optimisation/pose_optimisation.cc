#include "slam/optimisation/pose_optimisation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "slam/geometry/lie.h"
#include "slam/optimisation/reprojection.h"

namespace corbslam {
namespace {

constexpr int kRounds = 4;
constexpr int kRobustRounds = 2;
constexpr int kIterations = 10;
constexpr int kMinObservations = 3;

struct Measurement {
  Eigen::Vector3d x_in_map;
  PixelMeasurement pixel;
};

struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
};

class PoseProblem {
 public:
  PoseProblem(const Camera& camera, absl::Span<const PoseObservation> observations)
      : camera_(camera) {
    measurements_.reserve(observations.size());
    for (const PoseObservation& o : observations) {
      measurements_.push_back(
          {o.x_in_map, MakeMeasurement(o.pixel, o.disparity_px, o.variance_px2)});
      const Measurement& m = measurements_.back();
      const bool usable = m.x_in_map.allFinite() && m.pixel.pixel.allFinite() &&
                          std::isfinite(m.pixel.inverse_variance);
      is_inlier_.push_back(usable ? 1 : 0);
      inliers_ += usable ? 1 : 0;
    }
  }

  const std::vector<char>& is_inlier() const { return is_inlier_; }
  int inliers() const { return inliers_; }

  void Classify(const Rigid3d& pose) {
    const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
    inliers_ = 0;
    for (size_t i = 0; i < measurements_.size(); ++i) {
      const PixelMeasurement& pixel = measurements_[i].pixel;
      const Eigen::Vector3d x = R * measurements_[i].x_in_map + pose.translation;
      const bool fits = x.z() > kMinDepth && ReprojectionResidual(camera_, x, pixel).squaredNorm() *
                                                     pixel.inverse_variance <=
                                                 pixel.MaxChi2();
      is_inlier_[i] = fits ? 1 : 0;
      inliers_ += fits ? 1 : 0;
    }
  }

  // Returns the cost of the inliers.
  double Evaluate(const Rigid3d& pose, bool robust) {
    const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
    double cost = 0;
    seen_.clear();
    for (size_t i = 0; i < measurements_.size(); ++i) {
      if (!is_inlier_[i]) continue;
      const PixelMeasurement& pixel = measurements_[i].pixel;
      const Eigen::Vector3d x = R * measurements_[i].x_in_map + pose.translation;
      const bool seen = x.z() > kMinDepth;
      const Eigen::Vector3d r =
          seen ? ReprojectionResidual(camera_, x, pixel) : Eigen::Vector3d::Zero();
      const double chi2 =
          seen ? r.squaredNorm() * pixel.inverse_variance : kUnseenFactor * pixel.MaxChi2();
      const RobustCost loss = robust ? HuberCost(chi2, pixel.MaxChi2()) : RobustCost{chi2, 1};
      cost += loss.cost;
      if (seen) seen_.push_back({x, r, loss.weight * pixel.inverse_variance, pixel.has_depth});
    }
    return cost;
  }

  // Linearises at the pose that was evaluated last.
  NormalEquations Linearise() const {
    NormalEquations equations;
    for (const Seen& seen : seen_) {
      const Eigen::Matrix<double, 6, 3> J_transposed =
          PoseJacobian(ReprojectionJacobian(camera_, seen.x_in_camera, seen.has_depth),
                       seen.x_in_camera)
              .transpose();
      const Eigen::Matrix<double, 6, 3> weighted = seen.weight * J_transposed;
      // The sums go column by column, so that six lie side by side in the processor's registers.
      for (int i = 0; i < 6; ++i) {
        equations.H.col(i) += weighted.col(0) * J_transposed(i, 0) +
                              weighted.col(1) * J_transposed(i, 1) +
                              weighted.col(2) * J_transposed(i, 2);
      }
      equations.b += weighted.col(0) * seen.residual[0] + weighted.col(1) * seen.residual[1] +
                     weighted.col(2) * seen.residual[2];
    }
    return equations;
  }

 private:
  // An inlier in front of the camera, where it was evaluated last.
  struct Seen {
    Eigen::Vector3d x_in_camera;
    Eigen::Vector3d residual;
    double weight;
    bool has_depth;
  };

  const Camera& camera_;
  std::vector<Measurement> measurements_;
  std::vector<char> is_inlier_;
  int inliers_ = 0;
  std::vector<Seen> seen_;
};

Rigid3d Perturb(const Vector6d& step, const Rigid3d& pose) {
  return Rigid3d{ExpSO3(step.tail<3>()), step.head<3>()} * pose;
}

// Minimises by Levenberg-Marquardt over six parameters.
Rigid3d Minimise(PoseProblem& problem, Rigid3d pose, bool robust) {
  double damping = 1e-5;
  double cost = problem.Evaluate(pose, robust);
  NormalEquations equations = problem.Linearise();
  for (int i = 0; i < kIterations; ++i) {
    Matrix6d damped = equations.H;
    damped.diagonal() += damping * equations.H.diagonal() + Vector6d::Constant(1e-9);
    const Vector6d step = damped.ldlt().solve(-equations.b);
    if (!step.allFinite()) break;
    const Rigid3d candidate = Perturb(step, pose);
    const double next_cost = problem.Evaluate(candidate, robust);
    if (!(next_cost < cost)) {
      damping *= 10;
      if (damping > 1e6 || step.norm() < 1e-10) break;
      continue;
    }
    const bool converged = cost - next_cost < 1e-6 * cost;
    pose = candidate;
    cost = next_cost;
    damping = std::max(damping * 0.1, 1e-9);
    if (converged) break;
    equations = problem.Linearise();
  }
  return pose;
}

}  // namespace

PoseEstimate OptimisePose(const Camera& camera, const Rigid3d& initial_camera_from_map,
                          absl::Span<const PoseObservation> observations) {
  PoseProblem problem(camera, observations);
  Rigid3d pose = initial_camera_from_map;
  for (int round = 0; round < kRounds && problem.inliers() >= kMinObservations; ++round) {
    // The first rounds begin at the initial pose, so that outliers let in before do not hold on.
    const Rigid3d& start = round < kRobustRounds ? initial_camera_from_map : pose;
    pose = Minimise(problem, start, round < kRobustRounds);
    problem.Classify(pose);
  }
  if (problem.inliers() < kMinObservations) {
    pose = initial_camera_from_map;
    problem.Classify(pose);
  }
  return {pose, problem.is_inlier(), problem.inliers()};
}

}  // namespace corbslam

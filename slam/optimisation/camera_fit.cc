#include "slam/optimisation/camera_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "slam/geometry/lie.h"
#include "slam/optimisation/reprojection.h"
#include "slam/optimisation/scaled_inverse.h"

namespace corbslam {
namespace {

// Pose, logarithm of both focal lengths, of fy alone, principal point, radial distortion.
constexpr int kBothFocals = 6;
constexpr int kAspect = 7;
constexpr int kCentreX = 8;
constexpr int kCentreY = 9;
constexpr int kRadial = 10;
constexpr int kNumbers = 11;
constexpr int kRounds = 15;
constexpr int kMinObservations = 2 * kNumbers;
// After scaling each number to its own information.
constexpr double kMinRelativeInformation = 1e-8;
// Errors that neighbours in the picture share, and the map's own, are not in the residuals.
constexpr double kSharedSigmas = 2;
constexpr double kMaxLogFocal = 1.5;

using Vector = Eigen::Matrix<double, kNumbers, 1>;
using Matrix = Eigen::Matrix<double, kNumbers, kNumbers>;
using Rows = Eigen::Matrix<double, 2, kNumbers>;

struct State {
  Camera camera;
  Rigid3d camera_from_map;
  double radial = 0;  // k1, of the squared tangent of the angle to the axis.
};

struct Sums {
  Matrix H = Matrix::Zero();
  Vector g = Vector::Zero();
  double chi2 = 0;
  int rows = 0;
};

// Projection less measurement, and its derivatives.
void Linearise(const State& state, const PoseObservation& o, const Eigen::Vector3d& x,
               Eigen::Vector2d& r, Rows& J) {
  const Camera& camera = state.camera;
  const Eigen::Vector2d n(x.x() / x.z(), x.y() / x.z());
  const double square = n.squaredNorm();
  const Eigen::Vector2d focal(camera.fx_px, camera.fy_px);
  const Eigen::Vector2d from_centre = focal.cwiseProduct(n) * (1 + state.radial * square);
  r = from_centre + Eigen::Vector2d(camera.cx_px, camera.cy_px) - o.pixel;
  // The lens is weak: its part in how a pixel moves with the point is left out.
  J.leftCols<6>() = PoseJacobian(ReprojectionJacobian(camera, x, false), x).topRows<2>();
  J.col(kBothFocals) = from_centre;
  J.col(kAspect) << 0, from_centre.y();
  J.col(kCentreX) << 1, 0;
  J.col(kCentreY) << 0, 1;
  J.col(kRadial) = focal.cwiseProduct(n) * square;
}

Sums Gather(const State& state, absl::Span<const PoseObservation> observations) {
  Sums sums;
  for (const PoseObservation& o : observations) {
    const Eigen::Vector3d x = state.camera_from_map * o.x_in_map;
    if (!(x.z() > kMinDepth)) continue;
    Eigen::Vector2d r;
    Rows J;
    Linearise(state, o, x, r, J);
    const double chi2 = r.squaredNorm() / o.variance_px2;
    const RobustCost loss = HuberCost(chi2, kChi2Mono);
    const double weight = loss.weight / o.variance_px2;
    sums.H += weight * J.transpose() * J;
    sums.g += weight * J.transpose() * r;
    sums.chi2 += loss.cost;
    sums.rows += 2;
  }
  return sums;
}

State Moved(const State& state, const Vector& step) {
  State moved = state;
  moved.camera_from_map = ExpSE3(step.head<6>()) * state.camera_from_map;
  moved.camera.fx_px *= std::exp(step[kBothFocals]);
  moved.camera.fy_px *= std::exp(step[kBothFocals] + step[kAspect]);
  moved.camera.cx_px += step[kCentreX];
  moved.camera.cy_px += step[kCentreY];
  moved.radial += step[kRadial];
  return moved;
}

// Levenberg and Marquardt's steps, each taken only where it helps.
void Minimise(absl::Span<const PoseObservation> observations, State& state, Sums& sums) {
  double damping = 1e-4;
  for (int round = 0; round < kRounds; ++round) {
    Matrix H = sums.H;
    H.diagonal() *= 1 + damping;
    const Vector step = H.ldlt().solve(-sums.g);
    if (!step.allFinite() || std::abs(step[kBothFocals]) > kMaxLogFocal) {
      damping *= 100;
      continue;
    }
    const State moved = Moved(state, step);
    const Sums there = Gather(moved, observations);
    if (there.rows < sums.rows || !(there.chi2 < sums.chi2)) {
      damping *= 10;
      continue;
    }
    const bool done = sums.chi2 - there.chi2 < 1e-4 * sums.chi2 / kRounds;
    state = moved;
    sums = there;
    damping = std::max(damping / 10, 1e-9);
    if (done) return;
  }
}

// Least squares of the disparities that are known: measured ones are so many times the true ones.
FittedNumber FitDisparity(const State& state, double baseline_m,
                          absl::Span<const PoseObservation> observations) {
  double measured = 0;
  double expected = 0;
  double squares = 0;
  int count = 0;
  for (const PoseObservation& o : observations) {
    const Eigen::Vector3d x = state.camera_from_map * o.x_in_map;
    if (!(o.disparity_px > 0) || !(x.z() > kMinDepth)) continue;
    const double true_px = state.camera.fx_px * baseline_m / x.z();
    measured += o.disparity_px * true_px / o.variance_px2;
    expected += true_px * true_px / o.variance_px2;
    squares += o.disparity_px * o.disparity_px / o.variance_px2;
    ++count;
  }
  if (count < kMinObservations || !(expected > 0) || !(measured > 0)) {
    return {0, std::numeric_limits<double>::infinity()};
  }
  const double share = measured / expected;
  const double left = std::max(squares - share * measured, 0.0) / (count - 1);
  return {std::log(share), kSharedSigmas * std::sqrt(left / expected) / share};
}

bool Differs(const FittedNumber& number, double allowed) {
  constexpr double kSigmas = 3.5;
  return std::abs(number.value) > allowed && std::abs(number.value) > kSigmas * number.sigma;
}

}  // namespace

std::optional<CameraFit> FitCamera(const Camera& camera, const Rigid3d& camera_from_map,
                                   absl::Span<const PoseObservation> observations) {
  if (observations.size() < kMinObservations) return std::nullopt;
  State state{camera, camera_from_map, 0};
  Sums sums = Gather(state, observations);
  if (sums.rows < 2 * kMinObservations) return std::nullopt;
  Minimise(observations, state, sums);
  const std::optional<Matrix> inverse = InvertScaled(sums.H, kMinRelativeInformation);
  if (!inverse.has_value()) return std::nullopt;
  const double noise = kSharedSigmas * std::sqrt(sums.chi2 / (sums.rows - kNumbers));
  const auto sigma = [&](int i) { return noise * std::sqrt((*inverse)(i, i)); };
  const double half = camera.width_px / (2 * state.camera.fx_px);
  CameraFit fit;
  fit.focal = {std::log(state.camera.fx_px / camera.fx_px), sigma(kBothFocals)};
  fit.aspect = {std::log(state.camera.fy_px / camera.fy_px) - fit.focal.value, sigma(kAspect)};
  fit.centre_x = {(state.camera.cx_px - camera.cx_px) / camera.width_px,
                  sigma(kCentreX) / camera.width_px};
  fit.centre_y = {(state.camera.cy_px - camera.cy_px) / camera.height_px,
                  sigma(kCentreY) / camera.height_px};
  fit.radial = {state.radial * half * half, sigma(kRadial) * half * half};
  fit.disparity = FitDisparity(state, camera.baseline_m, observations);
  fit.camera_from_map = state.camera_from_map;
  fit.camera = state.camera;
  fit.camera.baseline_m *= std::exp(fit.disparity.value);
  return fit;
}

bool IsAnotherCamera(const CameraFit& fit) {
  constexpr double kFocal = 0.015;
  constexpr double kShape = 0.025;
  constexpr double kLens = 0.01;
  constexpr double kDisparity = 0.06;
  return Differs(fit.focal, kFocal) || Differs(fit.aspect, kShape) ||
         Differs(fit.centre_x, kShape) || Differs(fit.centre_y, kShape) ||
         Differs(fit.radial, kLens) || Differs(fit.disparity, kDisparity);
}

}  // namespace corbslam

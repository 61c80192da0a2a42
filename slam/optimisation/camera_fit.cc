#include "slam/optimisation/camera_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "slam/optimisation/reprojection.h"
#include "slam/optimisation/scaled_inverse.h"

namespace corbslam {
namespace {

// Pose, logarithm of both focal lengths, of fy alone, principal point, lens.
constexpr int kBothFocals = 6;
constexpr int kAspect = 7;
constexpr int kCentreX = 8;
constexpr int kCentreY = 9;
constexpr int kRadial = 10;
constexpr int kRadial4 = 11;
constexpr int kTangentialY = 12;
constexpr int kTangentialX = 13;
constexpr int kNumbers = 14;
constexpr int kRounds = 20;
constexpr int kRoundsOfScale = 6;
constexpr int kMinObservations = 22;
// After scaling each number to its own information.
constexpr double kMinRelativeInformation = 1e-14;
// A camera that nobody vouches for differs from the one that is said by about so much: focal
// lengths by a factor of two, the rest in shares of the picture.
constexpr double kSigmaFocal = 0.7;
constexpr double kSigmaAspect = 0.3;
constexpr double kSigmaCentre = 0.25;
constexpr double kSigmaRadial = 0.3;
constexpr double kSigmaRadial4 = 0.1;
constexpr double kSigmaTangential = 0.05;
// Observations in one cell of the picture, a square of this share of its width, are taken to share
// their errors. With fewer cells their sums say little.
constexpr double kFitCellShare = 1.0 / 24;
constexpr size_t kMinFitCells = 40;
constexpr double kFewFitCells = 3;
constexpr double kLastScale_px = 2.5;

using Vector = Eigen::Matrix<double, kNumbers, 1>;
using Matrix = Eigen::Matrix<double, kNumbers, kNumbers>;
using Rows = Eigen::Matrix<double, 2, kNumbers>;

struct State {
  BentCamera bent;
  Rigid3d camera_from_map;
  Vector moved = Vector::Zero();  // From the given camera; the pose's six are not used.
};

struct Sums {
  Matrix H = Matrix::Zero();
  Vector g = Vector::Zero();
  double cost = 0;
  int rows = 0;
};

Vector PriorOf(const Camera& camera) {
  const double half = camera.width_px / (2 * camera.fx_px);
  Vector information = Vector::Zero();
  const auto set = [&](int i, double sigma) { information[i] = 1 / (sigma * sigma); };
  set(kBothFocals, kSigmaFocal);
  set(kAspect, kSigmaAspect);
  set(kCentreX, kSigmaCentre * camera.width_px);
  set(kCentreY, kSigmaCentre * camera.height_px);
  set(kRadial, kSigmaRadial / (half * half));
  set(kRadial4, kSigmaRadial4 / (half * half * half * half));
  set(kTangentialY, kSigmaTangential / half);
  set(kTangentialX, kSigmaTangential / half);
  return information;
}

// What p1 and p2 move at a tangent, each for 1.
Eigen::Matrix2d TangentialParts(const Eigen::Vector2d& n) {
  const double square = n.squaredNorm();
  Eigen::Matrix2d parts;
  parts << 2 * n.x() * n.y(), square + 2 * n.x() * n.x(),  //
      square + 2 * n.y() * n.y(), 2 * n.x() * n.y();
  return parts;
}

Eigen::Vector2d Tangential(const BentCamera& bent, const Eigen::Vector2d& n) {
  return TangentialParts(n) * Eigen::Vector2d(bent.p1, bent.p2);
}

// Projection less measurement, and its derivatives.
void Linearise(const State& state, const PoseObservation& o, const Eigen::Vector3d& x,
               Eigen::Vector2d& r, Rows& J) {
  const Camera& camera = state.bent.camera;
  const Eigen::Vector2d n(x.x() / x.z(), x.y() / x.z());
  const double square = n.squaredNorm();
  const double bent = 1 + square * (state.bent.k1 + square * state.bent.k2);
  const double slope = 2 * state.bent.k1 + 4 * state.bent.k2 * square;
  const Eigen::Vector2d focal(camera.fx_px, camera.fy_px);
  const Eigen::Vector2d from_centre = focal.cwiseProduct(n * bent + Tangential(state.bent, n));
  r = from_centre + Eigen::Vector2d(camera.cx_px, camera.cy_px) - o.pixel;
  const auto& [p1, p2] = std::pair(state.bent.p1, state.bent.p2);
  Eigen::Matrix2d of_decentring;
  of_decentring << 2 * p1 * n.y() + 6 * p2 * n.x(), 2 * p1 * n.x() + 2 * p2 * n.y(),  //
      2 * p1 * n.x() + 2 * p2 * n.y(), 6 * p1 * n.y() + 2 * p2 * n.x();
  const Eigen::Matrix2d of_tangents =
      focal.asDiagonal() *
      (bent * Eigen::Matrix2d::Identity() + slope * n * n.transpose() + of_decentring);
  Eigen::Matrix3d of_point = Eigen::Matrix3d::Zero();
  of_point.topLeftCorner<2, 2>() = of_tangents / x.z();
  of_point.topRightCorner<2, 1>() = -of_tangents * n / x.z();
  J.leftCols<6>() = PoseJacobian(of_point, x).topRows<2>();
  J.col(kBothFocals) = from_centre;
  J.col(kAspect) << 0, from_centre.y();
  J.col(kCentreX) << 1, 0;
  J.col(kCentreY) << 0, 1;
  J.col(kRadial) = focal.cwiseProduct(n) * square;
  J.col(kRadial4) = focal.cwiseProduct(n) * square * square;
  J.middleCols<2>(kTangentialY) = focal.asDiagonal() * TangentialParts(n);
}

// Huber's loss, or with a scale that of Geman and McClure, which forgets what is far off.
RobustCost LossOf(double chi2, double scale) {
  if (!(scale > 0)) return HuberCost(chi2, kChi2Mono);
  const double share = scale * scale / (scale * scale + chi2);
  return {chi2 * share, share * share};
}

Sums Gather(const State& state, absl::Span<const PoseObservation> observations, const Vector& prior,
            double scale) {
  Sums sums;
  for (const PoseObservation& o : observations) {
    const Eigen::Vector3d x = state.camera_from_map * o.x_in_map;
    if (!(x.z() > kMinDepth)) {
      sums.cost += scale > 0 ? scale * scale : kUnseenFactor * kChi2Mono;
      continue;
    }
    Eigen::Vector2d r;
    Rows J;
    Linearise(state, o, x, r, J);
    const RobustCost loss = LossOf(r.squaredNorm() / o.variance_px2, scale);
    const double weight = loss.weight / o.variance_px2;
    sums.H += weight * J.transpose() * J;
    sums.g += weight * J.transpose() * r;
    sums.cost += loss.cost;
    sums.rows += 2;
  }
  sums.H.diagonal() += prior;
  sums.g += prior.cwiseProduct(state.moved);
  sums.cost += state.moved.cwiseAbs2().dot(prior);
  return sums;
}

State Moved(const State& state, const Vector& step) {
  State moved = state;
  moved.camera_from_map = ExpSE3(step.head<6>()) * state.camera_from_map;
  moved.bent.camera.fx_px *= std::exp(step[kBothFocals]);
  moved.bent.camera.fy_px *= std::exp(step[kBothFocals] + step[kAspect]);
  moved.bent.camera.cx_px += step[kCentreX];
  moved.bent.camera.cy_px += step[kCentreY];
  moved.bent.k1 += step[kRadial];
  moved.bent.k2 += step[kRadial4];
  moved.bent.p1 += step[kTangentialY];
  moved.bent.p2 += step[kTangentialX];
  moved.moved.tail<kNumbers - 6>() += step.tail<kNumbers - 6>();
  return moved;
}

// Levenberg and Marquardt's steps, each taken only where it helps.
Sums Minimise(absl::Span<const PoseObservation> observations, const Vector& prior, double scale,
              int rounds, State& state) {
  constexpr double kMaxLogFocal = 1;
  Sums sums = Gather(state, observations, prior, scale);
  double damping = 1e-4;
  for (int round = 0; round < rounds; ++round) {
    Matrix H = sums.H;
    H.diagonal() *= 1 + damping;
    const Vector step = H.ldlt().solve(-sums.g);
    const bool is_sane = step.allFinite() && std::abs(step[kBothFocals]) < kMaxLogFocal &&
                         std::abs(step[kAspect]) < kMaxLogFocal;
    if (!is_sane) {
      damping *= 100;
      continue;
    }
    const State moved = Moved(state, step);
    const Sums there = Gather(moved, observations, prior, scale);
    if (!(there.cost < sums.cost)) {
      damping *= 10;
      continue;
    }
    const bool done = sums.cost - there.cost < 1e-4 * sums.cost / rounds;
    state = moved;
    sums = there;
    damping = std::max(damping / 10, 1e-9);
    if (done) break;
  }
  return sums;
}

State StartOf(const Camera& camera, const Rigid3d& camera_from_map,
              const CameraFitOptions& options) {
  State state;
  state.bent = options.start.value_or(BentCamera{.camera = camera});
  state.camera_from_map = camera_from_map;
  const Camera& start = state.bent.camera;
  state.moved[kBothFocals] = std::log(start.fx_px / camera.fx_px);
  state.moved[kAspect] = std::log(start.fy_px / camera.fy_px) - state.moved[kBothFocals];
  state.moved[kCentreX] = start.cx_px - camera.cx_px;
  state.moved[kCentreY] = start.cy_px - camera.cy_px;
  state.moved[kRadial] = state.bent.k1;
  state.moved[kRadial4] = state.bent.k2;
  state.moved[kTangentialY] = state.bent.p1;
  state.moved[kTangentialX] = state.bent.p2;
  return state;
}

// Returns the covariance of all numbers: H^-1 G H^-1, where G has the prior, the noise that the
// residuals show, and what neighbours in the picture share (PoseCovariance).
std::optional<Matrix> CovarianceOf(const State& state,
                                   absl::Span<const PoseObservation> observations,
                                   const Vector& prior, const Sums& sums) {
  const std::optional<Matrix> inverse = InvertScaled(sums.H, kMinRelativeInformation);
  if (!inverse.has_value()) return std::nullopt;
  const double side_px = kFitCellShare * state.bent.camera.width_px;
  std::map<std::pair<int, int>, Vector> scores;
  for (const PoseObservation& o : observations) {
    const Eigen::Vector3d x = state.camera_from_map * o.x_in_map;
    if (!(x.z() > kMinDepth)) continue;
    Eigen::Vector2d r;
    Rows J;
    Linearise(state, o, x, r, J);
    const double weight =
        HuberCost(r.squaredNorm() / o.variance_px2, kChi2Mono).weight / o.variance_px2;
    const std::pair<int, int> cell = {static_cast<int>(std::floor(o.pixel.x() / side_px)),
                                      static_cast<int>(std::floor(o.pixel.y() / side_px))};
    scores.try_emplace(cell, Vector::Zero()).first->second += weight * J.transpose() * r;
  }
  const double noise = sums.cost / std::max(sums.rows - kNumbers, 1);
  Matrix H = sums.H;
  H.diagonal() -= prior;
  Matrix spread = (scores.size() < kMinFitCells ? kFewFitCells : 1) * noise * H;
  for (const auto& [cell, score] : scores) spread += score * score.transpose();
  spread.diagonal() += prior;
  return Matrix(*inverse * spread * *inverse);
}

// Least squares of the disparities that are known: measured ones are so many times the true ones.
FittedNumber FitDisparity(const State& state, double baseline_m,
                          absl::Span<const PoseObservation> observations) {
  constexpr double kSharedSigmas = 2;
  double measured = 0;
  double expected = 0;
  double squares = 0;
  int count = 0;
  for (const PoseObservation& o : observations) {
    const Eigen::Vector3d x = state.camera_from_map * o.x_in_map;
    if (!(o.disparity_px > 0) || !(x.z() > kMinDepth)) continue;
    const double true_px = state.bent.camera.fx_px * baseline_m / x.z();
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

// Returns the tangent that a lens without p1 and p2 bends to `seen`; nullopt where it folds back.
std::optional<Eigen::Vector2d> StraightenRadially(const BentCamera& bent,
                                                  const Eigen::Vector2d& seen) {
  const double far = seen.norm();
  double r = far;
  for (int i = 0; i < 8; ++i) {
    const double square = r * r;
    const double slope = 1 + square * (3 * bent.k1 + 5 * bent.k2 * square);
    if (!(slope > 0.1)) return std::nullopt;
    r -= (r * (1 + square * (bent.k1 + square * bent.k2)) - far) / slope;
  }
  if (!(far > 0) || !(r > 0)) return std::nullopt;
  return Eigen::Vector2d(seen * (r / far));
}

bool Differs(const FittedNumber& number, double allowed) {
  constexpr double kSigmas = 4;
  return std::abs(number.value) > allowed && std::abs(number.value) > kSigmas * number.sigma;
}

}  // namespace

Eigen::Vector2d BentCamera::Project(const Eigen::Vector3d& x_in_camera) const {
  const Eigen::Vector2d n = x_in_camera.head<2>() / x_in_camera.z();
  const double square = n.squaredNorm();
  const Eigen::Vector2d seen = n * (1 + square * (k1 + square * k2)) + Tangential(*this, n);
  return {camera.fx_px * seen.x() + camera.cx_px, camera.fy_px * seen.y() + camera.cy_px};
}

Eigen::Vector2d BentCamera::Straighten(const Eigen::Vector2d& pixel) const {
  constexpr int kDecentringRounds = 4;
  const Eigen::Vector2d seen((pixel.x() - camera.cx_px) / camera.fx_px,
                             (pixel.y() - camera.cy_px) / camera.fy_px);
  Eigen::Vector2d n = seen;
  for (int i = 0; i < kDecentringRounds; ++i) {
    const auto straight = StraightenRadially(*this, seen - Tangential(*this, n));
    if (!straight.has_value()) return pixel;
    const bool is_there = *straight == n;
    n = *straight;
    if (is_there) break;
  }
  return {camera.fx_px * n.x() + camera.cx_px, camera.fy_px * n.y() + camera.cy_px};
}

std::optional<CameraFit> FitCamera(const Camera& camera, const Rigid3d& camera_from_map,
                                   absl::Span<const PoseObservation> observations,
                                   const CameraFitOptions& options) {
  if (observations.size() < kMinObservations) return std::nullopt;
  const Vector prior = PriorOf(camera);
  State state = StartOf(camera, camera_from_map, options);
  for (double scale = options.first_scale_px; scale > kLastScale_px; scale /= 2) {
    Minimise(observations, prior, scale, kRoundsOfScale, state);
  }
  const double last_scale_px = options.first_scale_px > 0 ? kLastScale_px : 0;
  const Sums sums = Minimise(observations, prior, last_scale_px, kRounds, state);
  if (sums.rows < 2 * kMinObservations) return std::nullopt;
  const std::optional<Matrix> covariance = CovarianceOf(state, observations, prior, sums);
  if (!covariance.has_value()) return std::nullopt;
  const auto number = [&](int i, double unit) {
    return FittedNumber{state.moved[i] / unit, std::sqrt((*covariance)(i, i)) / unit};
  };
  const double half = camera.width_px / (2 * state.bent.camera.fx_px);
  CameraFit fit;
  fit.focal = number(kBothFocals, 1);
  fit.aspect = number(kAspect, 1);
  fit.centre_x = number(kCentreX, camera.width_px);
  fit.centre_y = number(kCentreY, camera.height_px);
  Vector at_edge = Vector::Zero();
  at_edge[kRadial] = half * half;
  at_edge[kRadial4] = half * half * half * half;
  fit.radial = {at_edge.dot(state.moved), std::sqrt(at_edge.dot(*covariance * at_edge))};
  fit.disparity = FitDisparity(state, camera.baseline_m, observations);
  fit.camera_from_map = state.camera_from_map;
  fit.pose_covariance = covariance->topLeftCorner<6, 6>();
  fit.bent = state.bent;
  fit.camera = state.bent.camera;
  fit.camera.baseline_m *= std::exp(fit.disparity.value);
  return fit;
}

Matrix6d CovarianceOfAnyCamera(const CameraFit& fit, const Rigid3d& camera_from_map) {
  const Vector6d off = LogSE3(fit.camera_from_map * camera_from_map.Inverse());
  return fit.pose_covariance + off * off.transpose();
}

bool IsAnotherCamera(const CameraFit& fit) {
  constexpr double kShape = 0.04;
  constexpr double kLens = 0.03;
  constexpr double kDisparity = 0.08;
  return Differs(fit.focal, kShape) || Differs(fit.aspect, kShape) ||
         Differs(fit.centre_x, kShape) || Differs(fit.centre_y, kShape) ||
         Differs(fit.radial, kLens) || Differs(fit.disparity, kDisparity);
}

}  // namespace corbslam

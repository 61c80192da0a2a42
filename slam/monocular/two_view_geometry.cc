#include "slam/monocular/two_view_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "slam/monocular/two_view_models.h"
#include "slam/solvers/sampling.h"
#include "slam/solvers/triangulation.h"

namespace corbslam {
namespace {

constexpr size_t kSample = 8;
constexpr size_t kSampleOfPlane = 4;
// Above this share of the scores the homography is taken (ORB-SLAM, T-RO 2015, section IV).
constexpr double kPlanarShare = 0.45;
// A point seen under less has no depth to speak of: it may be at infinity. So has one that is seen
// under less than this many standard deviations.
constexpr double kLeastParallax_rad = 0.0063;
constexpr double kLeastSigmas = 2.5;
// A point agrees if it is seen within two standard deviations.
constexpr double kMaxChi2 = 4;

// A model with the best score so far.
struct Fitted {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  ModelScore score;
};

using Matches = absl::Span<const TwoViewMatch>;
using NormalisedMatches = std::vector<NormalisedMatch>;

NormalisedMatches Normalise(const Camera& camera, Matches matches) {
  const double focal_px = std::sqrt(camera.fx_px * camera.fy_px);
  const auto normalised = [&](const Eigen::Vector2d& pixel) {
    return Eigen::Vector2d((pixel.x() - camera.cx_px) / camera.fx_px,
                           (pixel.y() - camera.cy_px) / camera.fy_px);
  };
  NormalisedMatches all;
  all.reserve(matches.size());
  for (const TwoViewMatch& match : matches) {
    all.push_back({normalised(match.pixel_1), normalised(match.pixel_2),
                   match.variance_px2 / (focal_px * focal_px)});
  }
  return all;
}

using Fit = std::optional<Eigen::Matrix3d> (*)(absl::Span<const NormalisedMatch>);
using ScoreModel = ModelScore (*)(const Eigen::Matrix3d&, absl::Span<const NormalisedMatch>);

void Try(Fit fit, ScoreModel score_model, absl::Span<const NormalisedMatch> sample,
         const NormalisedMatches& all, Fitted& best) {
  const std::optional<Eigen::Matrix3d> model = fit(sample);
  if (!model.has_value()) return;
  ModelScore score = score_model(*model, all);
  if (score.score > best.score.score) best = {*model, std::move(score)};
}

// Fits the best model again to all that agree with it, as long as that gains anything.
void Polish(Fit fit, ScoreModel score_model, const NormalisedMatches& all, Fitted& best) {
  constexpr int kMostRounds = 5;
  for (int round = 0; round < kMostRounds; ++round) {
    NormalisedMatches inliers;
    for (size_t i = 0; i < best.score.is_inlier.size(); ++i) {
      if (best.score.is_inlier[i]) inliers.push_back(all[i]);
    }
    if (inliers.size() < kSample) return;
    const double before = best.score.score;
    Try(fit, score_model, inliers, all, best);
    if (best.score.score <= before) return;
  }
}

// How what agrees with a model lies if the camera moved so.
struct Laid {
  Rigid3d two_from_one;
  std::vector<std::optional<TwoViewPoint>> points;
  int in_front = 0;  // Those too far away to tell among them.
  int depths = 0;
  std::vector<double> parallax_rad;  // Of points with a depth beyond doubt, the largest first.

  double with_depth() const { return depths; }
};

bool IsSeenAt(const Camera& camera, const Eigen::Vector3d& x_in_camera,
              const Eigen::Vector2d& pixel, double variance_px2) {
  return (Project(camera, x_in_camera) - pixel).squaredNorm() <= kMaxChi2 * variance_px2;
}

double ParallaxOf(const Camera& camera, const TwoViewMatch& match, const Rigid3d& two_from_one) {
  const Eigen::Vector3d ray_1 =
      two_from_one.rotation * Unproject(camera, match.pixel_1.x(), match.pixel_1.y(), 1);
  const Eigen::Vector3d ray_2 = Unproject(camera, match.pixel_2.x(), match.pixel_2.y(), 1);
  return std::atan2(ray_1.cross(ray_2).norm(), ray_1.dot(ray_2));
}

Laid LayOut(const Camera& camera, Matches matches, const std::vector<char>& is_inlier,
            const Rigid3d& two_from_one, double min_sigmas) {
  const double focal_px = std::sqrt(camera.fx_px * camera.fy_px);
  Laid laid;
  laid.two_from_one = two_from_one;
  laid.points.resize(matches.size());
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!is_inlier[i]) continue;
    const TwoViewMatch& match = matches[i];
    const double parallax_rad = ParallaxOf(camera, match, two_from_one);
    const double sigma_rad = std::sqrt(2 * match.variance_px2) / focal_px;
    if (parallax_rad < std::max(kLeastParallax_rad, kLeastSigmas * sigma_rad)) {
      ++laid.in_front;
      continue;
    }
    const auto point = TriangulatePoint(camera, Rigid3d::Identity(), match.pixel_1, camera,
                                        two_from_one, match.pixel_2);
    if (!point.has_value() ||
        !IsSeenAt(camera, point->x_in_map, match.pixel_1, match.variance_px2) ||
        !IsSeenAt(camera, two_from_one * point->x_in_map, match.pixel_2, match.variance_px2)) {
      continue;
    }
    ++laid.in_front;
    ++laid.depths;
    if (parallax_rad >= min_sigmas * sigma_rad) laid.parallax_rad.push_back(parallax_rad);
    laid.points[i] = TwoViewPoint{point->x_in_map, parallax_rad};
  }
  std::sort(laid.parallax_rad.begin(), laid.parallax_rad.end(), std::greater<>());
  return laid;
}

// The angle that so many points reach at least; 0 where there are fewer.
double ParallaxReached(const Laid& laid, int points) {
  const auto count = static_cast<size_t>(std::max(points, 1));
  return laid.parallax_rad.size() < count ? 0 : laid.parallax_rad[count - 1];
}

// More points in front of the camera are better evidence; where all are far away nothing is.
TwoViewVerdict Judge(const std::vector<Laid>& laid, size_t best, int inliers,
                     const TwoViewOptions& options) {
  if (ParallaxReached(laid[best], options.min_points) < options.min_parallax_rad) {
    return TwoViewVerdict::kLittleParallax;
  }
  if (laid[best].in_front < options.min_share_in_front * inliers) {
    return TwoViewVerdict::kAmbiguous;
  }
  for (size_t i = 0; i < laid.size(); ++i) {
    // What is far away lies before the cameras whichever way they moved.
    if (i != best && laid[i].with_depth() > options.max_second_share * laid[best].with_depth()) {
      return TwoViewVerdict::kAmbiguous;
    }
  }
  return TwoViewVerdict::kFound;
}

void Decide(const Camera& camera, Matches matches, const Fitted& model,
            const TwoViewOptions& options, TwoViewGeometry& geometry) {
  const auto inliers = static_cast<int>(
      std::count(model.score.is_inlier.begin(), model.score.is_inlier.end(), char{1}));
  if (inliers < options.min_points) return;
  const std::vector<Rigid3d> motions =
      geometry.is_planar ? MotionsOfHomography(model.matrix) : MotionsOfEssential(model.matrix);
  geometry.verdict = TwoViewVerdict::kLittleParallax;
  if (motions.empty()) return;
  std::vector<Laid> laid;
  for (const Rigid3d& motion : motions) {
    laid.push_back(
        LayOut(camera, matches, model.score.is_inlier, motion, options.min_parallax_sigmas));
  }
  const auto best = std::max_element(laid.begin(), laid.end(), [](const Laid& a, const Laid& b) {
    return std::pair(a.with_depth(), a.in_front) < std::pair(b.with_depth(), b.in_front);
  });
  geometry.parallax_rad = ParallaxReached(*best, options.min_points);
  geometry.verdict = Judge(laid, static_cast<size_t>(best - laid.begin()), inliers, options);
  if (geometry.verdict != TwoViewVerdict::kFound) return;
  geometry.two_from_one = best->two_from_one;
  geometry.points = std::move(best->points);
}

}  // namespace

TwoViewGeometry FindTwoViewGeometry(const Camera& camera, absl::Span<const TwoViewMatch> matches,
                                    const TwoViewOptions& options) {
  TwoViewGeometry geometry;
  if (matches.size() < std::max(kSample, static_cast<size_t>(std::max(options.min_points, 0)))) {
    return geometry;
  }
  const NormalisedMatches all = Normalise(camera, matches);
  Sampler sampler(options.seed);
  Fitted homography;
  Fitted essential;
  for (int i = 0; i < options.iterations; ++i) {
    NormalisedMatches sample;
    for (const size_t index : sampler.Draw<kSample>(all.size())) sample.push_back(all[index]);
    Try(&FitHomography, &ScoreHomography, absl::MakeConstSpan(sample).first(kSampleOfPlane), all,
        homography);
    Try(&FitEssential, &ScoreEssential, sample, all, essential);
  }
  Polish(&FitHomography, &ScoreHomography, all, homography);
  Polish(&FitEssential, &ScoreEssential, all, essential);
  const double both = homography.score.score + essential.score.score;
  if (!(both > 0)) return geometry;
  geometry.homography_share = homography.score.score / both;
  geometry.is_planar = geometry.homography_share > kPlanarShare;
  Decide(camera, matches, geometry.is_planar ? homography : essential, options, geometry);
  return geometry;
}

}  // namespace corbslam

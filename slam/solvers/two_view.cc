#include "slam/solvers/two_view.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

constexpr size_t kMinMatches = 8;
// The homography is taken where its share of the support is above this (ORB-SLAM, eq. 3).
constexpr double kHomographyShare = 0.45;
// A second solution with this share of the best one's points makes the geometry unclear.
constexpr double kAmbiguousShare = 0.7;
// Motions nearer than this are one solution: a homography's two fall together where the camera
// moves along the plane's normal.
constexpr double kSameRotation_rad = 0.01;
constexpr double kSameDirection_rad = 0.05;
constexpr size_t kParallaxRank = 50;
// Triangulated points may miss their pixels by this many times the model's bound.
constexpr double kReprojectionFactor = 2;

struct Pixels {
  std::vector<cv::Point2d> a;
  std::vector<cv::Point2d> b;
};

cv::Matx33d IntrinsicMatrix(const Camera& camera) {
  return {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1};
}

Rigid3d ToRigid(const cv::Matx33d& R, const cv::Vec3d& t) {
  Eigen::Matrix3d rotation;
  rotation << R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2);
  return {Eigen::Quaterniond(rotation).normalized(),
          Eigen::Vector3d(t[0], t[1], t[2]).normalized()};
}

std::vector<Rigid3d> PosesOfEssential(const cv::Mat& E) {
  // More than three rows are several matrices, none of which is clear.
  if (E.rows != 3 || E.cols != 3) return {};
  cv::Matx33d R1;
  cv::Matx33d R2;
  cv::Vec3d t;
  cv::decomposeEssentialMat(E, R1, R2, t);
  return {ToRigid(R1, t), ToRigid(R1, -t), ToRigid(R2, t), ToRigid(R2, -t)};
}

std::vector<Rigid3d> PosesOfHomography(const cv::Mat& H, const cv::Matx33d& K) {
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  std::vector<cv::Mat> normals;
  cv::decomposeHomographyMat(H, K, rotations, translations, normals);
  std::vector<Rigid3d> poses;
  for (size_t i = 0; i < rotations.size(); ++i) {
    if (cv::norm(translations[i]) < 1e-9) continue;
    poses.push_back(ToRigid(cv::Matx33d(rotations[i]), cv::Vec3d(translations[i])));
  }
  return poses;
}

bool Fits(const Camera& camera, const Eigen::Vector3d& x_in_camera, const Eigen::Vector2d& pixel,
          double max_error_px) {
  return (Project(camera, x_in_camera) - pixel).norm() <= max_error_px;
}

TwoViewResult TriangulateAll(const Camera& camera, absl::Span<const PixelMatch> matches,
                             const Rigid3d& b_from_a, double max_error_px) {
  TwoViewResult result;
  result.b_from_a = b_from_a;
  result.is_triangulated.assign(matches.size(), 0);
  result.x_in_a.assign(matches.size(), Eigen::Vector3d::Zero());
  std::vector<double> parallaxes_rad;
  for (size_t i = 0; i < matches.size(); ++i) {
    const auto point = TriangulatePoint(camera, Rigid3d::Identity(), matches[i].pixel_in_a, camera,
                                        b_from_a, matches[i].pixel_in_b);
    if (!point || !Fits(camera, point->x_in_map, matches[i].pixel_in_a, max_error_px) ||
        !Fits(camera, b_from_a * point->x_in_map, matches[i].pixel_in_b, max_error_px)) {
      continue;
    }
    result.is_triangulated[i] = 1;
    result.x_in_a[i] = point->x_in_map;
    ++result.triangulated;
    parallaxes_rad.push_back(std::acos(point->parallax_cosine));
  }
  if (parallaxes_rad.empty()) return result;
  std::sort(parallaxes_rad.begin(), parallaxes_rad.end(), std::greater<>());
  result.parallax_rad = parallaxes_rad[std::min(kParallaxRank, parallaxes_rad.size()) - 1];
  return result;
}

struct Models {
  cv::Mat E;
  cv::Mat H;
  int essential_support = 0;
  int homography_support = 0;
};

Models FitModels(const Pixels& pixels, const cv::Matx33d& K, const TwoViewOptions& options) {
  Models models;
  cv::Mat mask;
  cv::setRNGSeed(static_cast<int>(options.seed & 0x7fffffff));
  models.E = cv::findEssentialMat(pixels.a, pixels.b, K, cv::RANSAC, options.confidence,
                                  options.max_error_px, mask);
  models.essential_support = mask.empty() ? 0 : cv::countNonZero(mask);
  cv::setRNGSeed(static_cast<int>(options.seed & 0x7fffffff));
  models.H = cv::findHomography(pixels.a, pixels.b, cv::RANSAC, options.max_error_px, mask, 2000,
                                options.confidence);
  models.homography_support = models.H.empty() || mask.empty() ? 0 : cv::countNonZero(mask);
  return models;
}

bool IsSameMotion(const Rigid3d& a, const Rigid3d& b) {
  return a.rotation.angularDistance(b.rotation) < kSameRotation_rad &&
         a.translation.dot(b.translation) > std::cos(kSameDirection_rad);
}

absl::StatusOr<TwoViewResult> ChooseClearBest(std::vector<TwoViewResult> candidates, size_t matches,
                                              const TwoViewOptions& options) {
  if (candidates.empty()) return absl::NotFoundError("two views: no model fits");
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const TwoViewResult& a, const TwoViewResult& b) {
                     return a.triangulated > b.triangulated;
                   });
  TwoViewResult& best = candidates[0];
  if (best.triangulated < options.min_points) {
    return absl::NotFoundError(absl::StrCat("two views: ", best.triangulated, " of ", matches,
                                            " matches triangulate, need ", options.min_points));
  }
  if (best.parallax_rad < options.min_parallax_rad) {
    return absl::NotFoundError(absl::StrCat("two views: parallax is ", best.parallax_rad,
                                            " rad, need ", options.min_parallax_rad));
  }
  for (size_t i = 1; i < candidates.size(); ++i) {
    if (candidates[i].triangulated <= kAmbiguousShare * best.triangulated) break;
    if (IsSameMotion(candidates[i].b_from_a, best.b_from_a)) continue;
    return absl::NotFoundError(absl::StrCat("two views: two solutions alike, with ",
                                            best.triangulated, " and ", candidates[i].triangulated,
                                            " points"));
  }
  return std::move(best);
}

}  // namespace

absl::StatusOr<TwoViewResult> EstimateTwoView(const Camera& camera,
                                              absl::Span<const PixelMatch> matches,
                                              const TwoViewOptions& options) {
  if (matches.size() < kMinMatches) {
    return absl::InvalidArgumentError(
        absl::StrCat("two views: ", matches.size(), " matches, need ", kMinMatches));
  }
  Pixels pixels;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!matches[i].pixel_in_a.allFinite() || !matches[i].pixel_in_b.allFinite()) {
      return absl::InvalidArgumentError(absl::StrCat("two views: match ", i, " is not finite"));
    }
    pixels.a.emplace_back(matches[i].pixel_in_a.x(), matches[i].pixel_in_a.y());
    pixels.b.emplace_back(matches[i].pixel_in_b.x(), matches[i].pixel_in_b.y());
  }
  try {
    const cv::Matx33d K = IntrinsicMatrix(camera);
    const Models models = FitModels(pixels, K, options);
    const double support = models.homography_support + models.essential_support;
    const bool is_flat = support > 0 && models.homography_support / support > kHomographyShare;
    std::vector<TwoViewResult> candidates;
    for (const Rigid3d& pose :
         is_flat ? PosesOfHomography(models.H, K) : PosesOfEssential(models.E)) {
      candidates.push_back(
          TriangulateAll(camera, matches, pose, kReprojectionFactor * options.max_error_px));
      candidates.back().from_homography = is_flat;
    }
    return ChooseClearBest(std::move(candidates), matches.size(), options);
  } catch (const cv::Exception& error) {
    return absl::NotFoundError(absl::StrCat("two views: ", error.what()));
  }
}

}  // namespace corbslam

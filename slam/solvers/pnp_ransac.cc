#include "slam/solvers/pnp_ransac.h"

#include <array>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/geometry/lie.h"
#include "slam/optimisation/reprojection.h"
#include "slam/solvers/sampling.h"

namespace corbslam {
namespace {

constexpr size_t kSampleSize = 4;
using Sample = std::array<size_t, kSampleSize>;

double Chi2(const Camera& camera, const Rigid3d& pose, const PoseObservation& o) {
  const Eigen::Vector3d x = pose * o.x_in_map;
  if (!(x.z() > kMinDepth)) return std::numeric_limits<double>::infinity();
  return (Project(camera, x) - o.pixel).squaredNorm() / o.variance_px2;
}

int CountInliers(const Camera& camera, const Rigid3d& pose,
                 absl::Span<const PoseObservation> observations, double max_chi2) {
  int inliers = 0;
  for (const PoseObservation& o : observations) {
    if (Chi2(camera, pose, o) <= max_chi2) ++inliers;
  }
  return inliers;
}

// Solves P3P on the first three, in normalised pixels; there are up to four poses.
std::vector<Rigid3d> SolveP3P(const Camera& camera, absl::Span<const PoseObservation> observations,
                              const Sample& sample) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (size_t i = 0; i < 3; ++i) {
    const PoseObservation& o = observations[sample[i]];
    points.emplace_back(o.x_in_map.x(), o.x_in_map.y(), o.x_in_map.z());
    pixels.emplace_back((o.pixel.x() - camera.cx_px) / camera.fx_px,
                        (o.pixel.y() - camera.cy_px) / camera.fy_px);
  }
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  try {
    cv::solveP3P(points, pixels, cv::Matx33d::eye(), cv::noArray(), rotations, translations,
                 cv::SOLVEPNP_P3P);
  } catch (const cv::Exception&) {
    return {};
  }
  std::vector<Rigid3d> poses;
  for (size_t i = 0; i < rotations.size(); ++i) {
    const cv::Mat& r = rotations[i];
    const cv::Mat& t = translations[i];
    const Rigid3d pose{ExpSO3({r.at<double>(0), r.at<double>(1), r.at<double>(2)}),
                       {t.at<double>(0), t.at<double>(1), t.at<double>(2)}};
    if (pose.translation.allFinite() && pose.rotation.coeffs().allFinite()) poses.push_back(pose);
  }
  return poses;
}

// Finds the one of P3P's poses that the sample's fourth observation fits best.
bool SolveSample(const Camera& camera, absl::Span<const PoseObservation> observations,
                 const Sample& sample, Rigid3d& best) {
  double least = std::numeric_limits<double>::infinity();
  for (const Rigid3d& pose : SolveP3P(camera, observations, sample)) {
    const double chi2 = Chi2(camera, pose, observations[sample[3]]);
    if (!(chi2 < least)) continue;
    least = chi2;
    best = pose;
  }
  return std::isfinite(least);
}

absl::Status CheckInput(absl::Span<const PoseObservation> observations) {
  if (observations.size() < kSampleSize) {
    return absl::InvalidArgumentError(
        absl::StrCat("PnP: ", observations.size(), " observations, need ", kSampleSize));
  }
  for (size_t i = 0; i < observations.size(); ++i) {
    const PoseObservation& o = observations[i];
    if (o.x_in_map.allFinite() && o.pixel.allFinite() && o.variance_px2 > 0) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("PnP: observation ", i, " is not finite or has a variance of 0"));
  }
  return absl::OkStatus();
}

absl::Status TooFew(int inliers, size_t count, int needed) {
  return absl::NotFoundError(
      absl::StrCat("PnP: ", inliers, " of ", count, " observations agree, need ", needed));
}

}  // namespace

absl::StatusOr<PoseEstimate> EstimatePose(const Camera& camera,
                                          absl::Span<const PoseObservation> observations,
                                          const PnpRansacOptions& options) {
  if (absl::Status status = CheckInput(observations); !status.ok()) return status;
  Sampler sampler(options.seed);
  Rigid3d best;
  int best_inliers = 0;
  int needed = options.max_iterations;
  for (int i = 0; i < needed; ++i) {
    Rigid3d pose;
    if (!SolveSample(camera, observations, sampler.Draw<kSampleSize>(observations.size()), pose)) {
      continue;
    }
    const int inliers = CountInliers(camera, pose, observations, options.max_chi2);
    if (inliers <= best_inliers) continue;
    best = pose;
    best_inliers = inliers;
    needed = RequiredIterations(static_cast<size_t>(inliers), observations.size(), kSampleSize,
                                options.confidence, options.max_iterations);
  }
  if (best_inliers < options.min_inliers) {
    return TooFew(best_inliers, observations.size(), options.min_inliers);
  }
  PoseEstimate estimate = OptimisePose(camera, best, observations);
  if (estimate.inliers < options.min_inliers) {
    return TooFew(estimate.inliers, observations.size(), options.min_inliers);
  }
  return estimate;
}

}  // namespace corbslam

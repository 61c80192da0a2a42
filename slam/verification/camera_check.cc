#include "slam/verification/camera_check.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "slam/optimisation/reprojection.h"
#include "slam/solvers/pnp_ransac.h"
#include "slam/verification/projection_search.h"

namespace corbslam {
namespace {

// Pairs that look alike are as far off as another focal length moves the edges of a picture.
constexpr double kAlikeScale_px = 100;
constexpr size_t kMaxAlike = 400;
// With fewer of the pairs that look alike, other focal lengths are tried as starts.
constexpr double kConvincingShare = 0.6;
constexpr double kOtherFocals[] = {0.35, 0.5, 0.7, 1.4, 2.0, 2.9};
constexpr int kOtherIterations = 60;
// A start's focal length is up to a fifth off, which moves pixels.
constexpr double kStartMaxChi2 = 150;
constexpr double kGrowRadii_px[] = {12, 6};
constexpr double kGrowScale_px = 6;

double Chi2Of(const CameraFit& fit, const PoseObservation& o) {
  const Eigen::Vector3d x = fit.camera_from_map * o.x_in_map;
  if (!(x.z() > kMinDepth)) return kUnseenFactor * kChi2Mono;
  return (fit.bent.Project(x) - o.pixel).squaredNorm() / o.variance_px2;
}

std::vector<PoseObservation> InliersOf(const CameraFit& fit,
                                       absl::Span<const PoseObservation> observations) {
  std::vector<PoseObservation> inliers;
  for (const PoseObservation& o : observations) {
    if (Chi2Of(fit, o) <= kChi2Mono) inliers.push_back(o);
  }
  return inliers;
}

// The frame as the fitted camera's pinhole would have seen it.
Keyframe Straightened(const Keyframe& frame, const BentCamera& bent) {
  Features features = frame.payload->features;
  for (Keypoint& keypoint : features.keypoints) {
    const Eigen::Vector2d pixel = bent.Straighten(keypoint.Pixel());
    keypoint.x_px = static_cast<float>(pixel.x());
    keypoint.y_px = static_cast<float>(pixel.y());
  }
  Keyframe straight;
  straight.payload = MakeKeyframePayload({}, 0, 0, std::make_shared<const Camera>(bent.camera),
                                         std::move(features));
  return straight;
}

// Looks for all points with the fitted camera, and fits it to what is found.
struct Grown {
  std::optional<CameraFit> fit;
  std::vector<PoseObservation> inliers;
};
Grown Grow(const Keyframe& frame, const std::vector<const MapPoint*>& points, CameraFit fit) {
  Grown grown;
  for (const double radius_px : kGrowRadii_px) {
    std::vector<PoseObservation> found;
    for (const ProjectionMatch& match :
         FindByProjection(points, Straightened(frame, fit.bent), fit.camera_from_map,
                          {.radius_px = radius_px, .check_disparity = false})) {
      const Keypoint& keypoint = frame.keypoints()[match.keypoint];
      found.push_back({points[match.point]->position_in_map, keypoint.Pixel(),
                       static_cast<double>(keypoint.disparity_px),
                       ScalePyramid::Variance_px2(keypoint.octave)});
    }
    const auto better = FitCamera(frame.camera(), fit.camera_from_map, found,
                                  {.start = fit.bent, .first_scale_px = kGrowScale_px});
    if (!better.has_value()) return grown;
    fit = *better;
    grown.inliers = InliersOf(fit, found);
  }
  grown.fit = FitCamera(frame.camera(), fit.camera_from_map, grown.inliers, {.start = fit.bent});
  return grown;
}

Camera WithFocal(const Camera& camera, double share) {
  Camera other = camera;
  other.fx_px *= share;
  other.fy_px *= share;
  other.baseline_m = 0;
  return other;
}

// Keeps of two fits that which more of the pairs that look alike agree with.
class BestFit {
 public:
  explicit BestFit(absl::Span<const PoseObservation> alike) : alike_(alike) {}

  void Take(const std::optional<CameraFit>& fit) {
    if (!fit.has_value()) return;
    const size_t inliers = InliersOf(*fit, alike_).size();
    if (best_.has_value() && inliers <= inliers_) return;
    best_ = fit;
    inliers_ = inliers;
  }
  const std::optional<CameraFit>& best() const { return best_; }
  bool IsConvincing() const {
    return static_cast<double>(inliers_) > kConvincingShare * static_cast<double>(alike_.size());
  }

 private:
  const absl::Span<const PoseObservation> alike_;
  std::optional<CameraFit> best_;
  size_t inliers_ = 0;
};

std::optional<CameraFit> FitFreely(const Camera& camera, const Rigid3d& camera_from_map,
                                   absl::Span<const PoseObservation> alike, uint64_t seed) {
  BestFit best(alike);
  best.Take(FitCamera(camera, camera_from_map, alike, {.first_scale_px = kAlikeScale_px}));
  for (const double share : kOtherFocals) {
    if (best.IsConvincing()) break;
    const Camera other = WithFocal(camera, share);
    const auto start = EstimatePose(other, alike,
                                    {.min_inliers = 8,
                                     .max_chi2 = kStartMaxChi2,
                                     .max_iterations = kOtherIterations,
                                     .seed = seed});
    if (!start.ok()) continue;
    best.Take(FitCamera(camera, start->camera_from_map, alike,
                        {.start = BentCamera{.camera = other}, .first_scale_px = kAlikeScale_px}));
  }
  return best.best();
}

double MedianDepth(const Rigid3d& camera_from_map, absl::Span<const PoseObservation> agreeing) {
  std::vector<double> depths;
  depths.reserve(agreeing.size());
  for (const PoseObservation& o : agreeing) depths.push_back((camera_from_map * o.x_in_map).z());
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

bool IsLoose(const Matrix6d& covariance, double depth, const CameraCheckOptions& options) {
  const double position = std::sqrt(covariance.topLeftCorner<3, 3>().trace());
  const double rotation_rad = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
  return !(position <= options.max_position_share * depth) ||
         !(rotation_rad <= options.max_rotation_rad);
}

}  // namespace

CameraCheck CheckCamera(const Keyframe& frame, const std::vector<const MapPoint*>& points,
                        const Rigid3d& camera_from_map, absl::Span<const PoseObservation> agreeing,
                        absl::Span<const PoseObservation> alike,
                        const CameraCheckOptions& options) {
  CameraCheck check;
  check.fit = FitCamera(frame.camera(), camera_from_map, agreeing);
  check.inliers = agreeing.size();
  const auto freely = FitFreely(frame.camera(), camera_from_map,
                                alike.first(std::min(alike.size(), kMaxAlike)), options.seed);
  for (const std::optional<CameraFit>& start : {freely, check.fit}) {
    if (!start.has_value()) continue;
    Grown grown = Grow(frame, points, *start);
    if (!grown.fit.has_value() || grown.inliers.size() < check.inliers) continue;
    check.fit = std::move(grown.fit);
    check.inliers = grown.inliers.size();
  }
  if (!check.fit.has_value()) return check;
  check.covariance = CovarianceOfAnyCamera(*check.fit, camera_from_map);
  check.gains =
      static_cast<double>(check.inliers) > options.max_gain * static_cast<double>(agreeing.size());
  if (IsAnotherCamera(*check.fit)) {
    check.verdict = CameraCheck::Verdict::kAnother;
  } else if (!check.gains &&
             !IsLoose(*check.covariance, MedianDepth(camera_from_map, agreeing), options)) {
    check.verdict = CameraCheck::Verdict::kAgrees;
  }
  return check;
}

}  // namespace corbslam

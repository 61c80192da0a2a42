#include "client_agent/source_checks/depth_parallax.h"

#include <opencv2/calib3d.hpp>
#include <vector>

#include "client_agent/source_checks/feature_matches.h"
#include "slam/sensor/corner_depth.h"
#include "slam/util/median.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMinMatches = 30;  // Nothing is estimated from fewer.
constexpr double kMaxEpipolarError_px = 1.5;
constexpr double kMaxReprojectionError_px = 3;
constexpr int kTrials = 200;
constexpr double kConfidence = 0.99;
constexpr size_t kLeastParallax = 40;  // Matches that one depth for all leaves unexplained.

// Undistorted pixels of both pictures, and the depth in the first.
struct DepthMatches {
  std::vector<cv::Point2d> first;
  std::vector<cv::Point2d> second;
  std::vector<double> depths_m;
};

std::optional<cv::Point2d> Undistorted(const RgbdCalibration& calibration,
                                       const Eigen::Vector2d& raw) {
  const auto ideal = UndistortPixel(calibration.camera, calibration.lens, raw);
  if (!ideal.has_value()) return std::nullopt;
  return cv::Point2d(ideal->x(), ideal->y());
}

DepthMatches FindMatches(const RgbdCalibration& calibration, const SensorImages& first,
                         const SensorImages& second) {
  DepthMatches matches;
  const CheckFeatures a = ExtractCheckFeatures(first.grey);
  const CheckFeatures b = ExtractCheckFeatures(second.grey);
  for (const FeatureMatch& match : MatchFeatures(a, b)) {
    Keypoint raw;
    raw.x_px = static_cast<float>(match.in_a.x());
    raw.y_px = static_cast<float>(match.in_a.y());
    const double depth_m = CornerDepth(first.depth, raw, calibration.depth_units_per_m);
    const std::optional<cv::Point2d> in_a = Undistorted(calibration, match.in_a);
    const std::optional<cv::Point2d> in_b = Undistorted(calibration, match.in_b);
    if (depth_m <= 0 || !in_a.has_value() || !in_b.has_value()) continue;
    matches.first.push_back(*in_a);
    matches.second.push_back(*in_b);
    matches.depths_m.push_back(depth_m);
  }
  return matches;
}

// Keeps matches that lie on each other's epipolar lines.
DepthMatches KeepRigid(const DepthMatches& matches) {
  DepthMatches rigid;
  if (matches.first.size() < kMinMatches) return rigid;
  std::vector<uint8_t> inliers;
  cv::findFundamentalMat(matches.first, matches.second, cv::FM_RANSAC, kMaxEpipolarError_px,
                         kConfidence, 5 * kTrials, inliers);
  for (size_t i = 0; i < inliers.size(); ++i) {
    if (inliers[i] == 0) continue;
    rigid.first.push_back(matches.first[i]);
    rigid.second.push_back(matches.second[i]);
    rigid.depths_m.push_back(matches.depths_m[i]);
  }
  return rigid;
}

size_t CountExplained(const Camera& camera, const DepthMatches& matches,
                      const std::vector<double>& depths_m) {
  std::vector<cv::Point3d> points;
  for (size_t i = 0; i < depths_m.size(); ++i) {
    const Eigen::Vector3d x =
        Unproject(camera, matches.first[i].x, matches.first[i].y, depths_m[i]);
    points.emplace_back(x.x(), x.y(), x.z());
  }
  const cv::Matx33d intrinsics(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0,
                               1);
  cv::Vec3d rotation;
  cv::Vec3d translation;
  std::vector<int> inliers;
  if (!cv::solvePnPRansac(points, matches.second, intrinsics, cv::noArray(), rotation, translation,
                          false, kTrials, kMaxReprojectionError_px, kConfidence, inliers,
                          cv::SOLVEPNP_EPNP)) {
    return 0;
  }
  return inliers.size();
}

}  // namespace

ParallaxEvidence CompareParallax(const RgbdCalibration& calibration, const SensorImages& first,
                                 const SensorImages& second) {
  ParallaxEvidence evidence;
  const DepthMatches rigid = KeepRigid(FindMatches(calibration, first, second));
  if (rigid.first.size() < kMinMatches) return evidence;
  evidence.rigid = rigid.first.size();
  evidence.with_depths = CountExplained(calibration.camera, rigid, rigid.depths_m);
  const std::vector<double> one_depth(rigid.depths_m.size(), Median(rigid.depths_m));
  evidence.with_one_depth = CountExplained(calibration.camera, rigid, one_depth);
  return evidence;
}

double MeasureParallaxGain(const RgbdCalibration& calibration, const Sample& sample) {
  ParallaxEvidence sum;
  size_t first = 0;
  for (size_t i = 1; i <= sample.size(); ++i) {
    if (i < sample.size() && sample[i].number == sample[i - 1].number + 1) continue;
    if (i - 1 > first) {
      const ParallaxEvidence evidence =
          CompareParallax(calibration, sample[first].images, sample[i - 1].images);
      sum.rigid += evidence.rigid;
      sum.with_depths += evidence.with_depths;
      sum.with_one_depth += evidence.with_one_depth;
    }
    first = i;
  }
  if (sum.rigid < sum.with_one_depth + kLeastParallax) return 1;
  return (static_cast<double>(sum.with_depths) - static_cast<double>(sum.with_one_depth)) /
         static_cast<double>(sum.rigid - sum.with_one_depth);
}

}  // namespace corbslam::client_agent

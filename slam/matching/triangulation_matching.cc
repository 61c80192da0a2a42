#include "slam/matching/triangulation_matching.h"

#include <algorithm>

#include "slam/matching/orientation_histogram.h"
#include "slam/matching/projection_matching.h"

namespace corbslam {
namespace {

// 95 % bound of chi2 with one degree of freedom.
constexpr double kMaxLineChi2 = 3.84;
// Any line fits a keypoint that is nearer to the epipole than this, at the finest level.
constexpr double kEpipoleRadius_px = 10;

struct Claim {
  uint32_t keypoint_a = kNoMatch;
  int distance = 257;
};

// The geometry of b's image as seen from a.
struct Epipolar {
  Eigen::Matrix3d line_b_from_pixel_a;
  Eigen::Vector3d epipole_b;  // In homogeneous coordinates.
};

Eigen::Matrix3d InverseIntrinsics(const Camera& camera) {
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();
  inverse(0, 0) = 1 / camera.fx_px;
  inverse(1, 1) = 1 / camera.fy_px;
  inverse(0, 2) = -camera.cx_px / camera.fx_px;
  inverse(1, 2) = -camera.cy_px / camera.fy_px;
  return inverse;
}

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

Epipolar ComputeEpipolar(const Keyframe& a, const Keyframe& b) {
  const Rigid3d b_from_a = b.camera_from_map * a.camera_from_map.Inverse();
  const Eigen::Matrix3d essential =
      CrossMatrix(b_from_a.translation) * b_from_a.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = b_from_a.translation;
  const Camera& camera = b.camera();
  return {InverseIntrinsics(camera).transpose() * essential * InverseIntrinsics(a.camera()),
          {camera.fx_px * t.x() + camera.cx_px * t.z(), camera.fy_px * t.y() + camera.cy_px * t.z(),
           t.z()}};
}

bool IsNearLine(const Eigen::Vector3d& line, const Keypoint& keypoint) {
  const double product = line.x() * keypoint.x_px + line.y() * keypoint.y_px + line.z();
  const double norm2 = line.head<2>().squaredNorm();
  return norm2 > 0 &&
         product * product < kMaxLineChi2 * norm2 * ScalePyramid::Variance_px2(keypoint.octave);
}

bool IsNearEpipole(const Eigen::Vector3d& epipole, const Keypoint& keypoint) {
  if (epipole.z() <= 0) return false;
  const Eigen::Vector2d offset = epipole.head<2>() / epipole.z() - keypoint.Pixel();
  return offset.squaredNorm() <
         kEpipoleRadius_px * kEpipoleRadius_px * ScalePyramid::Scale(keypoint.octave);
}

void MatchWithinNode(const Keyframe& a, const NodeFeatures& node_a, const Keyframe& b,
                     const NodeFeatures& node_b, const Epipolar& epipolar, int max_distance,
                     std::vector<Claim>& claims) {
  for (const uint32_t i : node_a.features) {
    if (a.points[i].IsValid()) continue;
    const Keypoint& keypoint_a = a.keypoints()[i];
    const Eigen::Vector3d line =
        epipolar.line_b_from_pixel_a * Eigen::Vector3d(keypoint_a.x_px, keypoint_a.y_px, 1);
    int best = max_distance + 1;
    uint32_t best_j = kNoMatch;
    for (const uint32_t j : node_b.features) {
      if (b.points[j].IsValid()) continue;
      const int distance = HammingDistance(a.descriptors()[i], b.descriptors()[j]);
      if (distance >= best) continue;
      const Keypoint& keypoint_b = b.keypoints()[j];
      const bool has_depth = keypoint_a.HasDepth() || keypoint_b.HasDepth();
      if (!has_depth && IsNearEpipole(epipolar.epipole_b, keypoint_b)) continue;
      if (!IsNearLine(line, keypoint_b)) continue;
      best = distance;
      best_j = j;
    }
    if (best_j != kNoMatch && best < claims[best_j].distance) claims[best_j] = {i, best};
  }
}

void DropOddOrientations(const Keyframe& a, const Keyframe& b, std::vector<Claim>& claims) {
  OrientationHistogram histogram;
  const auto angle_a = [&](size_t j) { return a.keypoints()[claims[j].keypoint_a].angle_rad; };
  for (size_t j = 0; j < claims.size(); ++j) {
    if (claims[j].keypoint_a != kNoMatch) histogram.Add(angle_a(j), b.keypoints()[j].angle_rad);
  }
  histogram.Select();
  for (size_t j = 0; j < claims.size(); ++j) {
    if (claims[j].keypoint_a == kNoMatch) continue;
    if (!histogram.IsKept(angle_a(j), b.keypoints()[j].angle_rad)) claims[j] = {};
  }
}

}  // namespace

std::vector<std::pair<uint32_t, uint32_t>> MatchForTriangulation(
    const Keyframe& a, const Keyframe& b, const TriangulationMatchingOptions& options) {
  std::vector<std::pair<uint32_t, uint32_t>> matches;
  if (a.words == nullptr || b.words == nullptr) return matches;
  const Epipolar epipolar = ComputeEpipolar(a, b);
  std::vector<Claim> claims(b.keypoints().size());
  auto node_a = a.words->direct_index.begin();
  auto node_b = b.words->direct_index.begin();
  while (node_a != a.words->direct_index.end() && node_b != b.words->direct_index.end()) {
    if (node_a->node == node_b->node) {
      MatchWithinNode(a, *node_a, b, *node_b, epipolar, options.max_distance, claims);
      ++node_a;
      ++node_b;
    } else if (node_a->node < node_b->node) {
      ++node_a;
    } else {
      ++node_b;
    }
  }
  if (options.check_orientation) DropOddOrientations(a, b, claims);
  for (size_t j = 0; j < claims.size(); ++j) {
    if (claims[j].keypoint_a == kNoMatch) continue;
    matches.emplace_back(claims[j].keypoint_a, static_cast<uint32_t>(j));
  }
  std::sort(matches.begin(), matches.end());
  return matches;
}

}  // namespace corbslam

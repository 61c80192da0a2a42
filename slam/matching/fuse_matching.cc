#include "slam/matching/fuse_matching.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include "slam/matching/match_point.h"
#include "slam/matching/projection_matching.h"

namespace corbslam {
namespace {

constexpr int kMaxDistance = 50;
constexpr double kMaxChi2Monocular = 5.991;
constexpr double kMaxChi2Stereo = 7.815;

bool FitsPixel(const PredictedView& view, const Keypoint& keypoint) {
  const Eigen::Vector2d error = view.pixel - keypoint.Pixel();
  double error2 = error.squaredNorm();
  double limit = kMaxChi2Monocular;
  if (keypoint.HasDepth() && view.disparity_px > 0) {
    const double right = error.x() - view.disparity_px + keypoint.disparity_px;
    error2 += right * right;
    limit = kMaxChi2Stereo;
  }
  return error2 <= limit * ScalePyramid::Variance_px2(keypoint.octave);
}

uint32_t FindKeypoint(const MatchPoint& point, const PredictedView& view, const Keyframe& keyframe,
                      double widening, std::vector<uint32_t>& near) {
  near.clear();
  const double radius_px = widening * ScalePyramid::Scale(view.octave);
  keyframe.payload->grid.FindNear(keyframe.keypoints(), view.pixel.x(), view.pixel.y(), radius_px,
                                  view.octave - 1, view.octave, near);
  int best = kMaxDistance + 1;
  uint32_t best_keypoint = kNoMatch;
  for (const uint32_t i : near) {
    if (!FitsPixel(view, keyframe.keypoints()[i])) continue;
    const int distance = HammingDistance(point.descriptor, keyframe.descriptors()[i]);
    if (distance >= best) continue;
    best = distance;
    best_keypoint = i;
  }
  return best_keypoint;
}

}  // namespace

std::vector<FuseProposal> FindFusable(const Map& map, const Keyframe& keyframe,
                                      absl::Span<const MapPointId> points, double widening) {
  std::vector<FuseProposal> proposals;
  std::vector<uint32_t> near;
  for (const MapPointId id : points) {
    const MapPoint* point = map.FindPoint(id);
    if (point == nullptr || point->observations.contains(keyframe.id())) continue;
    const MatchPoint match = MakeMatchPoint(*point);
    const std::optional<PredictedView> view =
        PredictView(match, keyframe.camera(), keyframe.camera_from_map);
    if (!view.has_value()) continue;
    const uint32_t keypoint = FindKeypoint(match, *view, keyframe, widening, near);
    if (keypoint == kNoMatch) continue;
    proposals.push_back({id, keypoint, keyframe.points[keypoint]});
  }
  std::sort(proposals.begin(), proposals.end(), [](const auto& a, const auto& b) {
    return std::tie(a.keypoint, a.point) < std::tie(b.keypoint, b.point);
  });
  return proposals;
}

}  // namespace corbslam

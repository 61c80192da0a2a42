#include "slam/matching/projection_matching.h"

#include <algorithm>
#include <cmath>

#include "slam/matching/orientation_histogram.h"

namespace corbslam {
namespace {

constexpr int kFar = 257;

struct Claim {
  uint32_t window = kNoMatch;
  int distance = kFar;
};

struct Best {
  uint32_t keypoint = kNoMatch;
  int distance = kFar;
  int octave = -1;
  int second_distance = kFar;
  int second_octave = -1;
};

bool DisparityAgrees(const SearchWindow& window, const Keypoint& keypoint) {
  if (window.disparity_px <= 0 || !keypoint.HasDepth()) return true;
  const double right_predicted = window.pixel.x() - window.disparity_px;
  const double right_seen = keypoint.x_px - keypoint.disparity_px;
  return std::abs(right_seen - right_predicted) <= window.radius_px;
}

Best FindBest(const SearchWindow& window, const KeyframePayload& image,
              absl::Span<const char> taken, const std::vector<uint32_t>& near) {
  Best best;
  for (const uint32_t i : near) {
    if (!taken.empty() && taken[i]) continue;
    const Keypoint& keypoint = image.features.keypoints[i];
    if (!DisparityAgrees(window, keypoint)) continue;
    const int distance = HammingDistance(window.descriptor, image.features.descriptors[i]);
    if (distance < best.distance) {
      best.second_distance = best.distance;
      best.second_octave = best.octave;
      best.distance = distance;
      best.octave = keypoint.octave;
      best.keypoint = i;
    } else if (distance < best.second_distance) {
      best.second_distance = distance;
      best.second_octave = keypoint.octave;
    }
  }
  return best;
}

bool IsClear(const Best& best, const ProjectionMatchingOptions& options) {
  if (best.distance > options.max_distance) return false;
  if (options.max_ratio >= 1 || best.octave != best.second_octave) return true;
  return best.distance <= options.max_ratio * best.second_distance;
}

void DropOddOrientations(absl::Span<const SearchWindow> windows,
                         const std::vector<Keypoint>& keypoints, std::vector<uint32_t>& matches) {
  OrientationHistogram histogram;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] != kNoMatch) {
      histogram.Add(windows[i].angle_rad, keypoints[matches[i]].angle_rad);
    }
  }
  histogram.Select();
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] == kNoMatch) continue;
    if (!histogram.IsKept(windows[i].angle_rad, keypoints[matches[i]].angle_rad)) {
      matches[i] = kNoMatch;
    }
  }
}

}  // namespace

std::vector<uint32_t> MatchWindows(absl::Span<const SearchWindow> windows,
                                   const KeyframePayload& image, absl::Span<const char> taken,
                                   const ProjectionMatchingOptions& options) {
  const std::vector<Keypoint>& keypoints = image.features.keypoints;
  std::vector<Claim> claims(keypoints.size());
  std::vector<uint32_t> near;
  for (size_t i = 0; i < windows.size(); ++i) {
    const SearchWindow& window = windows[i];
    near.clear();
    image.grid.FindNear(keypoints, window.pixel.x(), window.pixel.y(), window.radius_px,
                        window.min_octave, window.max_octave, near);
    const Best best = FindBest(window, image, taken, near);
    if (best.keypoint == kNoMatch || !IsClear(best, options)) continue;
    Claim& claim = claims[best.keypoint];
    if (best.distance < claim.distance) claim = {static_cast<uint32_t>(i), best.distance};
  }
  std::vector<uint32_t> matches(windows.size(), kNoMatch);
  for (size_t k = 0; k < claims.size(); ++k) {
    if (claims[k].window != kNoMatch) matches[claims[k].window] = static_cast<uint32_t>(k);
  }
  if (options.check_orientation) DropOddOrientations(windows, keypoints, matches);
  return matches;
}

SearchWindow MakeSearchWindow(const MatchPoint& point, const PredictedView& view, double widening) {
  constexpr double kStraightCosine = 0.998;
  constexpr double kStraightRadius_px = 2.5;
  constexpr double kAsideRadius_px = 4.0;
  SearchWindow window;
  window.pixel = view.pixel;
  window.radius_px = widening * ScalePyramid::Scale(view.octave) *
                     (view.view_cosine > kStraightCosine ? kStraightRadius_px : kAsideRadius_px);
  window.disparity_px = view.disparity_px;
  window.min_octave = view.octave - 1;
  window.max_octave = view.octave;
  window.descriptor = point.descriptor;
  return window;
}

}  // namespace corbslam

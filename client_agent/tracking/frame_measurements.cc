#include "client_agent/tracking/frame_measurements.h"

#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "client_agent/map/provisional_keyframes.h"

namespace corbslam::client_agent {
namespace {

// 95 % bounds of chi square with two degrees of freedom, and with one.
constexpr double kMaxPixelChi2 = 5.991;
constexpr double kMaxDisparityChi2 = 3.841;

struct Residual {
  double depth = 0;
  Eigen::Vector2d pixel_px = Eigen::Vector2d::Zero();
  double disparity_px = 0;
};

// Returns nullopt where the point is behind the camera.
std::optional<Residual> ResidualOf(const Keypoint& keypoint, const Camera& camera,
                                   const Eigen::Vector3d& point_in_camera) {
  const double depth = point_in_camera.z();
  if (depth <= 0) return std::nullopt;
  return Residual{depth, keypoint.Pixel() - Project(camera, point_in_camera),
                  keypoint.disparity_px - DisparityFromDepth(camera, depth)};
}

bool IsNoise(const KeypointMeasurement& measurement, double own_variance_px2) {
  const double pixel_chi2 =
      measurement.shift_px.squaredNorm() / (measurement.variance_px2 + own_variance_px2);
  const double disparity_chi2 = measurement.disparity_shift_px * measurement.disparity_shift_px /
                                (measurement.disparity_variance_px2 + own_variance_px2);
  return pixel_chi2 <= kMaxPixelChi2 && disparity_chi2 <= kMaxDisparityChi2;
}

// The point's own error is in both residuals, and cancels.
std::optional<KeypointMeasurement> Measure(const Keyframe& keyframe, uint32_t index,
                                           const MapPoint& point, const Rigid3d& frame_from_map,
                                           const Keypoint& seen) {
  const Keypoint& keypoint = keyframe.keypoints()[index];
  const auto in_frame = ResidualOf(seen, keyframe.camera(), frame_from_map * point.position_in_map);
  const auto in_keyframe =
      ResidualOf(keypoint, keyframe.camera(), keyframe.camera_from_map * point.position_in_map);
  if (!in_frame.has_value() || !in_keyframe.has_value()) return std::nullopt;
  // A pixel of the frame is so many in the keyframe. A disparity scales by the square, because it
  // is one over depth.
  const double scale = in_frame->depth / in_keyframe->depth;
  KeypointMeasurement measurement;
  measurement.keyframe = keyframe.id();
  measurement.keypoint = index;
  measurement.shift_px = scale * in_frame->pixel_px - in_keyframe->pixel_px;
  measurement.variance_px2 = scale * scale * ScalePyramid::Variance_px2(seen.octave);
  if (seen.HasDepth() && keypoint.HasDepth()) {
    measurement.disparity_shift_px =
        scale * scale * in_frame->disparity_px - in_keyframe->disparity_px;
    measurement.disparity_variance_px2 = scale * scale * measurement.variance_px2;
  }
  if (!IsNoise(measurement, ScalePyramid::Variance_px2(keypoint.octave))) return std::nullopt;
  return measurement;
}

// Ids of one local map are in the order in which its keyframes were made.
std::optional<std::pair<KeyframeId, uint32_t>> NewestOf(const MapPoint& point, LocalMapId own) {
  const auto& observations = point.observations;
  const auto after = observations.upper_bound({own, std::numeric_limits<uint32_t>::max()});
  if (after == observations.begin()) return std::nullopt;
  const auto& [id, keypoint] = *std::prev(after);
  if (id.local_map != own) return std::nullopt;
  return std::make_pair(id, keypoint);
}

}  // namespace

std::vector<KeypointMeasurement> FindMeasurements(const Map& map, LocalMapId own,
                                                  const Frame& frame) {
  std::vector<KeypointMeasurement> measurements;
  const Keyframe* reference = map.FindKeyframe(frame.reference);
  if (reference == nullptr) return measurements;
  // The map, and with it the frame's reference, may have moved since the frame was tracked.
  const Rigid3d frame_from_map = frame.camera_from_reference * reference->camera_from_map;
  const KeyframeId settled = NewestBut(map, own, kProvisionalKeyframes);
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    if (frame.associations[i].kind != Association::Kind::kMapPoint) continue;
    const MapPoint* point = map.FindPoint(frame.associations[i].id);
    if (point == nullptr) continue;
    const auto newest = NewestOf(*point, own);
    if (!newest.has_value() || (settled.IsValid() && newest->first <= settled)) continue;
    const auto measurement = Measure(*map.FindKeyframe(newest->first), newest->second, *point,
                                     frame_from_map, frame.keypoints()[i]);
    if (measurement.has_value()) measurements.push_back(*measurement);
  }
  return measurements;
}

}  // namespace corbslam::client_agent

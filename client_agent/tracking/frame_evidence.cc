#include "client_agent/tracking/frame_evidence.h"

#include "slam/optimisation/pose_covariance.h"
#include "slam/verification/frame_location.h"

namespace corbslam::client_agent {
namespace {

// What looks no more like a point than this, or like another one nearly as much, is no pair.
constexpr int kMaxAlikeDistance = 50;
constexpr double kMaxOfSecondAlike = 0.8;

}  // namespace

FrameEvidence::FrameEvidence(const Frame& frame, const std::vector<PointInView>& points)
    : frame_(frame) {
  as_keyframe_.payload = frame.payload;
  points_.reserve(points.size());
  for (const PointInView& in_view : points) {
    MapPoint& point = points_.emplace_back();
    point.id = in_view.point.id;
    point.position_in_map = in_view.point.position_in_map;
    point.normal_in_map = in_view.point.normal_in_map;
    point.min_distance = in_view.point.min_distance;
    point.max_distance = in_view.point.max_distance;
    point.descriptor = in_view.point.descriptor;
  }
}

CameraCheck FrameEvidence::CheckCamera() const {
  return corbslam::CheckCamera(as_keyframe_, Pointers(), frame_.camera_from_map,
                               ObservationsOf(frame_), LooksAlike());
}

int FrameEvidence::InliersNeeded() const {
  return CountInliersNeeded(as_keyframe_, Pointers(), frame_.camera_from_map).needed;
}

std::vector<const MapPoint*> FrameEvidence::Pointers() const {
  std::vector<const MapPoint*> pointers;
  pointers.reserve(points_.size());
  for (const MapPoint& point : points_) pointers.push_back(&point);
  return pointers;
}

// Wherever they are in the picture: where they should be depends on the camera.
std::vector<PoseObservation> FrameEvidence::LooksAlike() const {
  std::vector<PoseObservation> pairs;
  for (const MapPoint& point : points_) {
    int best = 257;
    int second = 257;
    size_t nearest = 0;
    for (size_t i = 0; i < frame_.descriptors().size(); ++i) {
      const int distance = HammingDistance(point.descriptor, frame_.descriptors()[i]);
      if (distance >= second) continue;
      if (distance < best) {
        second = best;
        best = distance;
        nearest = i;
      } else {
        second = distance;
      }
    }
    if (best > kMaxAlikeDistance || best > kMaxOfSecondAlike * second) continue;
    const Keypoint& keypoint = frame_.keypoints()[nearest];
    pairs.push_back({point.position_in_map, keypoint.Pixel(),
                     static_cast<double>(keypoint.disparity_px),
                     ScalePyramid::Variance_px2(keypoint.octave)});
  }
  return pairs;
}

std::optional<Matrix6d> AnyCamerasCovariance(const Frame& frame) {
  const std::vector<PoseObservation> observations = ObservationsOf(frame);
  const std::optional<Matrix6d> of_own =
      PoseCovariance(frame.camera(), frame.camera_from_map, observations);
  const std::optional<CameraFit> fit =
      FitCamera(frame.camera(), frame.camera_from_map, observations);
  if (!of_own.has_value() || !fit.has_value()) return std::nullopt;
  return InMapAxes(frame.camera_from_map,
                   *of_own + CovarianceOfAnyCamera(*fit, frame.camera_from_map));
}

}  // namespace corbslam::client_agent

#include "client_agent/tracking/frame.h"

#include <utility>

#include "client_agent/mapping/nearest_keypoints.h"
#include "slam/optimisation/pose_covariance.h"

namespace corbslam::client_agent {
namespace {

// The observations of a frame's associations, and the keypoint of each.
struct FrameObservations {
  std::vector<PoseObservation> observations;
  std::vector<size_t> keypoint_of;
};

FrameObservations NumberedObservationsOf(const Frame& frame) {
  FrameObservations of;
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    if (frame.associations[i].kind == Association::Kind::kNone) continue;
    const Keypoint& keypoint = frame.keypoints()[i];
    of.observations.push_back({frame.associations[i].position_in_map, keypoint.Pixel(),
                               keypoint.disparity_px, ScalePyramid::Variance_px2(keypoint.octave)});
    of.keypoint_of.push_back(i);
  }
  return of;
}

}  // namespace

Frame MakeFrame(KeyframePayload picture) {
  Frame frame;
  frame.associations.resize(picture.features.keypoints.size());
  frame.payload = MakeKeyframePayload(std::move(picture));
  return frame;
}

void Refresh(const Map& map, const MapHistory& history, Frame& frame) {
  if (const auto reference = history.CameraFromMap(map, frame.reference)) {
    frame.camera_from_map = frame.camera_from_reference * *reference;
  }
  const Keyframe* keyframe = map.FindKeyframe(frame.keyframe);
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    Association& association = frame.associations[i];
    MapPointId id = association.id;
    if (keyframe != nullptr) id = keyframe->points[i];
    if (!id.IsValid()) {
      association = {};
      continue;
    }
    id = history.CurrentPoint(id);
    if (const MapPoint* point = map.FindPoint(id)) {
      association = {Association::Kind::kMapPoint, id, point->position_in_map};
    } else {
      association = {};
    }
  }
}

InlierCount OptimiseFramePose(const Rigid3d& initial_camera_from_map, LocalMapId own,
                              Frame& frame) {
  const auto [observations, keypoint_of] = NumberedObservationsOf(frame);
  const PoseEstimate estimate = OptimisePose(frame.camera(), initial_camera_from_map, observations);
  frame.camera_from_map = estimate.camera_from_map;
  InlierCount count;
  for (size_t k = 0; k < keypoint_of.size(); ++k) {
    Association& association = frame.associations[keypoint_of[k]];
    if (!estimate.is_inlier[k]) {
      association = {};
    } else if (association.kind == Association::Kind::kTemporary) {
      ++count.temporary;
    } else {
      ++count.map_points;
      count.foreign += association.id.local_map != own;
    }
  }
  return count;
}

std::optional<Matrix6d> FramePoseCovariance(const Frame& frame) {
  const std::optional<Matrix6d> covariance =
      PoseCovariance(frame.camera(), frame.camera_from_map, ObservationsOf(frame));
  if (!covariance.has_value()) return std::nullopt;
  return InMapAxes(frame.camera_from_map, *covariance);
}

std::vector<MapPointId> SeenPoints(const Frame& frame) {
  std::vector<MapPointId> seen;
  for (const Association& association : frame.associations) {
    if (association.kind == Association::Kind::kMapPoint) seen.push_back(association.id);
  }
  return seen;
}

std::vector<PoseObservation> ObservationsOf(const Frame& frame) {
  return NumberedObservationsOf(frame).observations;
}

void AddTemporaryPoints(Frame& frame) {
  constexpr size_t kAtLeast = 100;
  const Rigid3d map_from_camera = frame.camera_from_map.Inverse();
  const auto add = [&](uint32_t i, double depth) {
    Association& association = frame.associations[i];
    if (association.kind != Association::Kind::kNone) return;
    const Keypoint& keypoint = frame.keypoints()[i];
    association.kind = Association::Kind::kTemporary;
    association.position_in_map =
        map_from_camera * Unproject(frame.camera(), keypoint.x_px, keypoint.y_px, depth);
  };
  for (const uint32_t i : NearestKeypoints(frame.camera(), frame.keypoints(), kAtLeast)) {
    add(i, DepthFromDisparity(frame.camera(), frame.keypoints()[i].disparity_px));
  }
  for (const FoundDepth& found : frame.found_depths) add(found.keypoint, found.depth);
}

void DropTemporaryPoints(Frame& frame) {
  for (Association& association : frame.associations) {
    if (association.kind == Association::Kind::kTemporary) association = {};
  }
}

void KeepFoundDepths(Frame& frame) {
  frame.found_depths.clear();
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    const Association& association = frame.associations[i];
    if (association.kind != Association::Kind::kTemporary) continue;
    const double depth = (frame.camera_from_map * association.position_in_map).z();
    if (depth > 0) frame.found_depths.push_back({static_cast<uint32_t>(i), depth});
  }
}

}  // namespace corbslam::client_agent

#include "slam/fusing/testing/long_drive.h"

#include <memory>
#include <utility>

namespace corbslam::testing {

void AddDrive(LocalMapId id, uint32_t start, uint32_t count, double depth_m, Map& map) {
  const auto camera = std::make_shared<const Camera>(Camera{.baseline_m = 0.1});
  Features features;
  features.keypoints.resize(1);
  features.descriptors.resize(1);
  for (uint32_t k = 0; k < count; ++k) {
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload({id, k}, k, 0, camera, features);
    keyframe.camera_from_map.translation = {-double(start + k), 0, 0};
    if (k > 0) keyframe.parent = {id, k - 1};
    map.AddKeyframe(std::move(keyframe));
    if (depth_m <= 0) continue;
    MapPoint point;
    point.id = {id, k};
    point.position_in_map = {double(start + k), 0, depth_m};
    point.reference = {id, k};
    map.AddPoint(point);
    map.AddObservation(point.id, {id, k}, 0);
  }
}

Overlap SayOverlap(const Map& map, KeyframeId query, KeyframeId candidate,
                   const Eigen::Vector3d& wrong_by, double turned_by_rad) {
  Rigid3d said = map.FindKeyframe(candidate)->camera_from_map *
                 map.FindKeyframe(query)->camera_from_map.Inverse();
  said.translation += wrong_by;
  said.rotation = Eigen::AngleAxisd(turned_by_rad, Eigen::Vector3d::UnitY()) * said.rotation;
  Overlap overlap;
  overlap.query = query;
  overlap.candidate = candidate;
  overlap.candidate_from_query = Similarity3d::FromRigid(said);
  overlap.verdict = OverlapVerdict::kAccepted;
  return overlap;
}

}  // namespace corbslam::testing

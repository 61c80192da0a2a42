#include "slam/fusing/testing/fused_maps.h"

#include <utility>

namespace corbslam::testing {
namespace {

void AddAll(const Map& from, Map& to) {
  for (const auto& [id, original] : from.keyframes()) {
    Keyframe keyframe;
    keyframe.payload = original.payload;
    keyframe.words = original.words;
    keyframe.camera_from_map = original.camera_from_map;
    to.AddKeyframe(std::move(keyframe));
  }
  for (const auto& [id, keyframe] : from.keyframes()) to.SetParent(id, keyframe.parent);
  for (const auto& [id, point] : from.points()) {
    to.AddPoint(point);
    for (const auto& [keyframe, keypoint] : point.observations) {
      to.AddObservation(id, keyframe, keypoint);
    }
  }
}

}  // namespace

Map ApplyFusing(const Map& target, const Map& source, const FuseMapsResult& result) {
  Map fused = target;
  AddAll(source, fused);
  for (const KeyframePose& pose : result.poses) {
    fused.SetPose(pose.id, pose.camera_from_map.ToRigid());
  }
  for (const PointPosition& position : result.positions) {
    fused.SetPosition(position.id, position.position_in_map);
  }
  for (const auto& merge : result.merges) fused.ReplacePoint(merge.member, merge.survivor);
  for (const auto& rejected : result.rejected) {
    fused.RemoveObservation(rejected.point, rejected.keyframe);
  }
  return fused;
}

std::map<KeyframeId, Rigid3d> JoinTruth(const SyntheticMap& a, const SyntheticMap& b) {
  std::map<KeyframeId, Rigid3d> truth = a.true_camera_from_world;
  truth.insert(b.true_camera_from_world.begin(), b.true_camera_from_world.end());
  return truth;
}

Map SplitPoints(const Map& map, uint32_t from) {
  Map split = map;
  uint32_t next = 1000000;
  for (const auto& [id, point] : map.points()) {
    const bool is_seen_twice = point.observations.begin()->first.index < from &&
                               point.observations.rbegin()->first.index >= from + 10;
    if (!is_seen_twice) continue;
    MapPoint twin = point;
    twin.id = {id.local_map, next++};
    split.AddPoint(twin);
    // The twin is where the drifted end of the map sees it.
    bool is_placed = false;
    for (const auto& [keyframe_id, keypoint] : point.observations) {
      if (keyframe_id.index < from) continue;
      split.RemoveObservation(id, keyframe_id);
      split.AddObservation(twin.id, keyframe_id, keypoint);
      if (is_placed) continue;
      const Keyframe& keyframe = *map.FindKeyframe(keyframe_id);
      const Keypoint& pixel = keyframe.keypoints()[keypoint];
      const double depth_m =
          DepthFromDisparity(keyframe.camera(), static_cast<double>(pixel.disparity_px));
      split.SetPosition(twin.id, keyframe.camera_from_map.Inverse() *
                                     Unproject(keyframe.camera(), static_cast<double>(pixel.x_px),
                                               static_cast<double>(pixel.y_px), depth_m));
      is_placed = true;
    }
    split.UpdatePointAppearance(id);
    split.UpdatePointAppearance(twin.id);
  }
  return split;
}

}  // namespace corbslam::testing

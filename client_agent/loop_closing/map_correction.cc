#include "client_agent/loop_closing/map_correction.h"

#include "absl/container/btree_map.h"

namespace corbslam::client_agent {
namespace {

// Returns everything as it was in the copy.
MapCorrection Unmoved(const Map& map, LocalMapId own) {
  MapCorrection correction;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id.local_map != own) {
      correction.fixed.insert(id);
      continue;
    }
    correction.keyframes[id] = {keyframe.camera_from_map,
                                Similarity3d::FromRigid(keyframe.camera_from_map)};
  }
  for (const auto& [id, point] : map.points()) {
    if (id.local_map == own) {
      correction.points[id] = {point.position_in_map, point.position_in_map};
    }
  }
  return correction;
}

void SetAfter(KeyframeId id, const Similarity3d& after, MapCorrection& correction) {
  if (const auto it = correction.keyframes.find(id); it != correction.keyframes.end()) {
    it->second.after = after;
  }
}

void SetAfter(MapPointId id, const Eigen::Vector3d& after, MapCorrection& correction) {
  if (const auto it = correction.points.find(id); it != correction.points.end()) {
    it->second.after = after;
  }
}

// Knows before_from_after of the place where a keyframe stands.
class Motions {
 public:
  Motions(const MapCorrection& correction, const Map& map) : correction_(correction), map_(map) {}

  // Returns the keyframe's own motion, else that of its nearest ancestor that has one; identity
  // without any.
  Similarity3d Of(KeyframeId id) const {
    for (const Keyframe* at = map_.FindKeyframe(id); at != nullptr;
         at = map_.FindKeyframe(at->parent)) {
      const auto it = correction_.keyframes.find(at->id());
      if (it == correction_.keyframes.end()) continue;
      return Similarity3d::FromRigid(it->second.before.Inverse()) * it->second.after;
    }
    return Similarity3d::Identity();
  }

 private:
  const MapCorrection& correction_;
  const Map& map_;
};

using MotionOfKeyframe = absl::btree_map<KeyframeId, Similarity3d>;

MotionOfKeyframe MotionsOfOwn(const MapCorrection& correction, LocalMapId own, const Map& map) {
  const Motions motions(correction, map);
  MotionOfKeyframe of;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id.local_map == own) of.emplace(id, motions.Of(id));
  }
  return of;
}

Eigen::Vector3d MovePoint(const MapCorrection& correction, const MotionOfKeyframe& motions,
                          const MapPoint& point) {
  const auto known = correction.points.find(point.id);
  const bool is_untouched =
      known != correction.points.end() && known->second.before == point.position_in_map;
  if (is_untouched) return known->second.after;
  const auto motion = motions.find(point.reference);
  if (motion == motions.end()) return point.position_in_map;
  return motion->second.Inverse() * point.position_in_map;
}

using Moved = std::map<KeyframeId, OwnCorrection::Motion>;

Moved MoveItems(const MapCorrection& correction, LocalMapId own, Map& map) {
  const MotionOfKeyframe motions = MotionsOfOwn(correction, own, map);
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> positions;
  for (const auto& [id, point] : map.points()) {
    if (id.local_map != own) continue;
    const Eigen::Vector3d position = MovePoint(correction, motions, point);
    if (position != point.position_in_map) positions.emplace_back(id, position);
  }
  Moved moved;
  for (const auto& [id, motion] : motions) {
    const Rigid3d before = map.FindKeyframe(id)->camera_from_map;
    const Rigid3d after = (Similarity3d::FromRigid(before) * motion).ToRigid();
    if ((before.translation - after.translation).norm() < 1e-12 &&
        RotationAngle(before.rotation.conjugate() * after.rotation) < 1e-12) {
      continue;
    }
    map.SetPose(id, after);
    moved[id] = {before, after};
  }
  for (const auto& [id, position] : positions) map.SetPosition(id, position);
  for (const auto& [id, position] : positions) map.UpdatePointGeometry(id);
  return moved;
}

}  // namespace

MapCorrection MakeCorrection(const Map& map, LocalMapId own, const FuseMapsResult& fused) {
  MapCorrection correction = Unmoved(map, own);
  for (const KeyframePose& pose : fused.poses) SetAfter(pose.id, pose.camera_from_map, correction);
  for (const PointPosition& position : fused.positions) {
    SetAfter(position.id, position.position_in_map, correction);
  }
  correction.merges = fused.merges;
  correction.rejected = fused.rejected;
  return correction;
}

MapCorrection MakeCorrection(const Map& map, LocalMapId own, const BundleResult& adjusted) {
  MapCorrection correction = Unmoved(map, own);
  for (const PoseUpdate& update : adjusted.poses) {
    SetAfter(update.id, Similarity3d::FromRigid(update.camera_from_map), correction);
  }
  for (const PositionUpdate& update : adjusted.positions) {
    SetAfter(update.id, update.position_in_map, correction);
  }
  for (const ObservationKey& outlier : adjusted.outliers) {
    correction.rejected.push_back({outlier.point, outlier.keyframe});
  }
  return correction;
}

std::map<KeyframeId, OwnCorrection::Motion> ApplyCorrection(const MapCorrection& correction,
                                                            LocalMapId own, Map& map) {
  Moved moved = MoveItems(correction, own, map);
  for (const FuseMapsResult::Merge& merge : correction.merges) {
    if (!map.ReplacePoint(merge.member, merge.survivor)) continue;
    if (merge.survivor.local_map == own) map.UpdatePointAppearance(merge.survivor);
  }
  for (const RejectedObservation& rejected : correction.rejected) {
    if (rejected.keyframe.local_map != own) continue;
    map.RemoveObservation(rejected.point, rejected.keyframe);
    const MapPoint* point = map.FindPoint(rejected.point);
    const bool is_lost = point != nullptr && point->observations.empty();
    if (is_lost && rejected.point.local_map == own) map.RemovePoint(rejected.point);
  }
  if (correction.loop_edge.has_value()) {
    map.AddLoopEdge(correction.loop_edge->first, correction.loop_edge->second);
  }
  return moved;
}

}  // namespace corbslam::client_agent

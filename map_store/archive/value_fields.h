// Says how plain values are archived (archive.h).
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_VALUE_FIELDS_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_VALUE_FIELDS_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>
#include <variant>

#include "absl/time/time.h"
#include "map_store/archive/archive.h"
#include "slam/camera/camera.h"
#include "slam/camera/recorded_camera.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/overlap.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam {

using map_store::MayBeConst;

constexpr ObservationChange::Kind LastValue(ObservationChange::Kind) {
  return ObservationChange::Kind::kRemoved;
}
constexpr OverlapVerdict LastValue(OverlapVerdict) { return OverlapVerdict::kTakenBack; }

template <typename Archive, MayBeConst<LocalMapId> T>
void Fields(Archive& archive, T& id) {
  archive(id.value);
}
template <typename Archive, typename T>
requires(MayBeConst<T, KeyframeId> || MayBeConst<T, MapPointId>) void Fields(Archive& archive,
                                                                             T& id) {
  archive(id.local_map, id.index);
}
template <typename Archive, MayBeConst<Rigid3d> T>
void Fields(Archive& archive, T& rigid) {
  archive(rigid.rotation, rigid.translation);
}
template <typename Archive, MayBeConst<Similarity3d> T>
void Fields(Archive& archive, T& similarity) {
  archive(similarity.scale, similarity.rotation, similarity.translation);
}
template <typename Archive, MayBeConst<Camera> T>
void Fields(Archive& archive, T& camera) {
  archive(camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, camera.width_px, camera.height_px,
          camera.baseline_m, camera.close_depth_m);
}
template <typename Archive, MayBeConst<RadialTangential> T>
void Fields(Archive& archive, T& lens) {
  archive(lens.k1, lens.k2, lens.p1, lens.p2, lens.k3, lens.k4, lens.k5, lens.k6);
}
template <typename Archive, MayBeConst<Equidistant> T>
void Fields(Archive& archive, T& lens) {
  archive(lens.k1, lens.k2, lens.k3, lens.k4);
}
template <typename Archive, MayBeConst<DoubleSphere> T>
void Fields(Archive& archive, T& lens) {
  archive(lens.xi, lens.alpha);
}
template <typename Archive, MayBeConst<UnifiedSphere> T>
void Fields(Archive& archive, T& lens) {
  archive(lens.xi, lens.distortion);
}
// Five numbers are the lens; a first one that is no number says that another lens follows.
template <typename Archive, MayBeConst<RawCamera> T>
void Fields(Archive& archive, T& camera) {
  RadialTangential five;
  if constexpr (std::is_const_v<T>) {
    const auto* const lens = std::get_if<RadialTangential>(&camera.lens);
    if (lens != nullptr && !lens->IsRational())
      five = *lens;
    else
      five.k1 = std::numeric_limits<double>::quiet_NaN();
  }
  archive(camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, five.k1, five.k2, five.p1,
          five.p2, five.k3);
  if constexpr (!std::is_const_v<T>) camera.lens = five;
  if (std::isnan(five.k1)) archive(camera.lens);
}
template <typename Archive, MayBeConst<RecordedCamera> T>
void Fields(Archive& archive, T& camera) {
  archive(camera.lens, camera.camera_from_recorded, camera.body_from_recorded);
}
// Archives whether there is a value, and then the value.
template <typename Archive, typename T>
requires(MayBeConst<T, std::optional<Rigid3d>> ||
         MayBeConst<T, std::optional<RecordedCamera>>) void Fields(Archive& archive, T& value) {
  bool is_there = value.has_value();
  archive(is_there);
  if constexpr (!std::is_const_v<T>) {
    value.reset();
    if (is_there) value.emplace();
  }
  if (is_there) archive(*value);
}
template <typename Archive, MayBeConst<Keypoint> T>
void Fields(Archive& archive, T& keypoint) {
  archive(keypoint.x_px, keypoint.y_px, keypoint.disparity_px, keypoint.angle_rad, keypoint.octave);
}
template <typename Archive, MayBeConst<Descriptor> T>
void Fields(Archive& archive, T& descriptor) {
  archive(descriptor.words);
}
template <typename Archive, MayBeConst<Features> T>
void Fields(Archive& archive, T& features) {
  archive(features.keypoints, features.descriptors);
}

// Archives a payload without its features. Records don't say which format they have, so that a
// value which older ones lack is to be announced by one of the upper bits of camera_index, which is
// at most 1,000, and to follow it.
template <typename Archive, MayBeConst<KeyframePayload> T>
void Fields(Archive& archive, T& payload) {
  archive(payload.id, payload.timestamp_ns, payload.camera_index);
}
template <typename Archive, typename Value>
void Pointed(Archive& archive, std::shared_ptr<const Value>& value) {
  auto read = std::make_shared<Value>();
  archive(*read);
  value = std::move(read);
}
template <typename Archive, typename Value>
void Pointed(Archive& archive, const std::shared_ptr<const Value>& value) {
  archive(*value);
}
template <typename Archive, typename T>
requires(MayBeConst<T, std::shared_ptr<const KeyframePayload>> ||
         MayBeConst<T, std::shared_ptr<const Camera>>) void Fields(Archive& archive, T& value) {
  Pointed(archive, value);
}

template <typename Archive, MayBeConst<FullKeyframe> T>
void Fields(Archive& archive, T& keyframe) {
  archive(keyframe.payload, keyframe.camera_from_local, keyframe.parent);
}
template <typename Archive, MayBeConst<LightKeyframe> T>
void Fields(Archive& archive, T& keyframe) {
  archive(keyframe.id, keyframe.camera_from_local, keyframe.parent);
}
template <typename Archive, MayBeConst<FullMapPoint> T>
void Fields(Archive& archive, T& point) {
  archive(point.id, point.position_in_local, point.reference, point.descriptor,
          point.normal_in_local, point.min_distance, point.max_distance);
}
template <typename Archive, MayBeConst<LightMapPoint> T>
void Fields(Archive& archive, T& point) {
  archive(point.id, point.position_in_local);
}
template <typename Archive, MayBeConst<ObservationChange> T>
void Fields(Archive& archive, T& change) {
  archive(change.kind, change.point, change.keyframe, change.keypoint);
}
template <typename Archive, MayBeConst<PointReplacement> T>
void Fields(Archive& archive, T& replacement) {
  archive(replacement.replaced, replacement.survivor);
}
template <typename Archive, MayBeConst<KeyframeRemoval> T>
void Fields(Archive& archive, T& removal) {
  archive(removal.id, removal.parent, removal.parent_from_removed);
}
template <typename Archive, MayBeConst<LoopEdge> T>
void Fields(Archive& archive, T& edge) {
  archive(edge.a, edge.b, edge.b_from_a);
}
template <typename Archive, MayBeConst<TrackedFrame> T>
void Fields(Archive& archive, T& frame) {
  archive(frame.timestamp_ns, frame.reference, frame.reference_from_camera);
}
template <typename Archive, MayBeConst<MapUpdateBatch> T>
void Fields(Archive& archive, T& batch) {
  archive(batch.local_map, batch.number, batch.first_camera_index, batch.cameras,
          batch.full_keyframes, batch.full_points, batch.light_keyframes, batch.light_points,
          batch.replacements, batch.observations, batch.removed_points, batch.removed_keyframes,
          batch.loop_edges, batch.tracked_frames, batch.lost_frames_ns, batch.closes_local_map);
}

template <typename Archive, MayBeConst<OverlapEvidence> T>
void Fields(Archive& archive, T& evidence) {
  archive(evidence.shared_words, evidence.word_matches, evidence.ransac_inliers,
          evidence.guided_matches, evidence.refined_inliers, evidence.projected_matches,
          evidence.visible_points, evidence.chance_matches, evidence.consistent_keyframes);
}
template <typename Archive, MayBeConst<PointPair> T>
void Fields(Archive& archive, T& pair) {
  archive(pair.query, pair.candidate);
}
template <typename Archive, MayBeConst<Overlap> T>
void Fields(Archive& archive, T& overlap) {
  archive(overlap.query, overlap.candidate, overlap.candidate_from_query, overlap.covariance,
          overlap.inliers, overlap.evidence, overlap.verdict);
}

}  // namespace corbslam

namespace Eigen {

template <typename Archive, corbslam::map_store::MayBeConst<Vector3d> T>
void Fields(Archive& archive, T& vector) {
  for (int i = 0; i < 3; ++i) archive(vector[i]);
}
template <typename Archive, corbslam::map_store::MayBeConst<Quaterniond> T>
void Fields(Archive& archive, T& rotation) {
  archive(rotation.w(), rotation.x(), rotation.y(), rotation.z());
}
// The matrix is symmetric, so that only its upper triangle is archived.
template <typename Archive, corbslam::map_store::MayBeConst<corbslam::Matrix7d> T>
void Fields(Archive& archive, T& covariance) {
  for (int row = 0; row < 7; ++row) {
    for (int column = row; column < 7; ++column) {
      archive(covariance(row, column));
      if constexpr (!std::is_const_v<T>) covariance(column, row) = covariance(row, column);
    }
  }
}

}  // namespace Eigen

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_VALUE_FIELDS_H_

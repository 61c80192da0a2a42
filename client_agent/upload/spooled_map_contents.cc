// What a SpooledMap gives: a map, and batches to keep in place of those that it was made of.
#include <algorithm>

#include "client_agent/upload/spooled_map.h"

namespace corbslam::client_agent {

void SpooledMap::Fill(const ComputeKeyframeWords& compute_words, Map& map) const {
  for (const auto& [id, full] : keyframes_) {
    Keyframe keyframe;
    keyframe.payload = full.payload;
    keyframe.camera_from_map = full.camera_from_local;
    keyframe.words = compute_words(full.payload->features.descriptors);
    map.AddKeyframe(std::move(keyframe));
  }
  for (const auto& [id, full] : keyframes_) {
    if (full.parent.IsValid()) map.SetParent(id, full.parent);
  }
  for (const auto& [id, full] : points_) {
    MapPoint point;
    point.id = id;
    point.position_in_map = full.position_in_local;
    point.reference = full.reference;
    point.descriptor = full.descriptor;
    point.normal_in_map = full.normal_in_local;
    point.min_distance = full.min_distance;
    point.max_distance = full.max_distance;
    map.AddPoint(std::move(point));
  }
  for (const auto& [id, seen] : observations_.keyframes()) {
    std::vector<MapPointId> own = seen;
    for (MapPointId& point : own) {
      if (!points_.contains(point)) point = MapPointId();
    }
    map.AddObservations(id, own);
  }
  for (const auto& [a, b] : loop_edges_) map.AddLoopEdge(a, b);
  // What points look like was told when they were new.
  for (const auto& [id, full] : points_) map.UpdatePointAppearance(id);
}

// Names the greatest indices that were ever given, and the latest time.
void SpooledMap::AppendNames(MapUpdateBatch& batch) const {
  if (next_keyframe_ > 0 && !keyframes_.contains({local_map_, next_keyframe_ - 1})) {
    batch.removed_keyframes.push_back(
        {{local_map_, next_keyframe_ - 1}, keyframes_.begin()->first, Rigid3d::Identity()});
  }
  if (next_point_ > 0) {
    const MapPointId last = {local_map_, next_point_ - 1};
    if (!points_.contains(last)) batch.removed_points.push_back(last);
  }
  if (newest_ns_.has_value()) batch.lost_frames_ns.push_back(*newest_ns_);
}

std::vector<MapUpdateBatch> SpooledMap::ToBatches(size_t max_keyframes, size_t max_points) const {
  std::vector<MapUpdateBatch> batches(1);
  batches.back().local_map = local_map_;
  const auto next = [&] {
    batches.emplace_back();
    batches.back().local_map = local_map_;
  };
  batches.back().cameras = cameras_;
  for (const auto& recorded : recorded_) {
    if (recorded.has_value()) batches.back().recorded_cameras.push_back(*recorded);
  }
  for (const auto& [id, keyframe] : keyframes_) {
    if (batches.back().full_keyframes.size() == max_keyframes) next();
    batches.back().full_keyframes.push_back(keyframe);
  }
  for (const auto& [id, point] : points_) {
    if (batches.back().full_points.size() == max_points) next();
    batches.back().full_points.push_back(point);
  }
  for (const auto& [id, seen] : observations_.keyframes()) {
    if (batches.back().observations.size() >= 4 * max_points) next();
    for (uint32_t k = 0; k < seen.size(); ++k) {
      if (!seen[k].IsValid()) continue;
      batches.back().observations.push_back({ObservationChange::Kind::kAdded, seen[k], id, k});
    }
  }
  for (const auto& [a, b] : loop_edges_) {
    const Rigid3d b_from_a =
        keyframes_.at(b).camera_from_local * keyframes_.at(a).camera_from_local.Inverse();
    batches.back().loop_edges.push_back({a, b, Similarity3d::FromRigid(b_from_a)});
  }
  AppendNames(batches.back());
  return batches;
}

}  // namespace corbslam::client_agent

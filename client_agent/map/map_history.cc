#include "client_agent/map/map_history.h"

namespace corbslam::client_agent {

MapPointId MapHistory::CurrentPoint(MapPointId id) const {
  for (auto it = replaced_points_.find(id); it != replaced_points_.end();
       it = replaced_points_.find(id)) {
    id = it->second.survivor;
  }
  return id;
}

std::optional<Rigid3d> MapHistory::CameraFromMap(const Map& map, KeyframeId id) const {
  Rigid3d removed_from_ancestor;
  while (true) {
    if (const Keyframe* keyframe = map.FindKeyframe(id)) {
      return removed_from_ancestor * keyframe->camera_from_map;
    }
    const auto it = removed_keyframes_.find(id);
    if (it == removed_keyframes_.end()) return std::nullopt;
    removed_from_ancestor = removed_from_ancestor * it->second.parent_from_removed.Inverse();
    id = it->second.parent;
  }
}

void MapHistory::OnKeyframeAdded(KeyframeId id) {
  removed_keyframes_.erase(id);
  own_items_.keyframes += id.local_map == own_ ? 1 : 0;
  if (next_) next_->OnKeyframeAdded(id);
}

void MapHistory::OnKeyframeMoved(KeyframeId id) {
  if (next_) next_->OnKeyframeMoved(id);
}

void MapHistory::OnParentChanged(KeyframeId id) {
  if (next_) next_->OnParentChanged(id);
}

void MapHistory::OnLoopEdgeAdded(KeyframeId a, KeyframeId b) {
  if (next_) next_->OnLoopEdgeAdded(a, b);
}

void MapHistory::OnKeyframeRemoved(KeyframeId id, KeyframeId parent,
                                   const Rigid3d& parent_from_removed) {
  removed_keyframes_[id] = {parent, parent_from_removed};
  own_items_.keyframes -= id.local_map == own_ ? 1 : 0;
  if (next_) next_->OnKeyframeRemoved(id, parent, parent_from_removed);
}

void MapHistory::OnPointAdded(MapPointId id) {
  // Others' points may come back after they went.
  replaced_points_.erase(id);
  own_items_.points += id.local_map == own_ ? 1 : 0;
  if (next_) next_->OnPointAdded(id);
}

void MapHistory::OnPointMoved(MapPointId id) {
  if (next_) next_->OnPointMoved(id);
}

void MapHistory::OnObservationAdded(MapPointId point, KeyframeId keyframe, uint32_t keypoint) {
  if (next_) next_->OnObservationAdded(point, keyframe, keypoint);
}

void MapHistory::OnObservationRemoved(MapPointId point, KeyframeId keyframe, uint32_t keypoint) {
  if (next_) next_->OnObservationRemoved(point, keyframe, keypoint);
}

void MapHistory::OnPointReplaced(MapPointId replaced, MapPointId survivor) {
  own_items_.points -= replaced.local_map == own_ ? 1 : 0;
  replaced_points_[replaced] = {survivor, ++replacements_};
  replacement_order_.emplace_back(replaced, replacements_);
  ForgetOldReplacements();
  if (next_) next_->OnPointReplaced(replaced, survivor);
}

void MapHistory::ForgetOldReplacements() {
  while (replacement_order_.size() > max_replacements_) {
    const auto [point, number] = replacement_order_.front();
    replacement_order_.pop_front();
    const auto it = replaced_points_.find(point);
    if (it != replaced_points_.end() && it->second.number == number) replaced_points_.erase(it);
  }
}

void MapHistory::OnPointRemoved(MapPointId id) {
  own_items_.points -= id.local_map == own_ ? 1 : 0;
  if (next_) next_->OnPointRemoved(id);
}

bool MapHistory::MayChangeKeypoints(KeyframeId id) const {
  return next_ == nullptr || next_->MayChangeKeypoints(id);
}

}  // namespace corbslam::client_agent

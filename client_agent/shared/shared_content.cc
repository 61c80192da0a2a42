#include "client_agent/shared/shared_content.h"

#include <algorithm>
#include <utility>

namespace corbslam::client_agent {

void SharedContent::Apply(const ArrivedUpdate& arrived) {
  const SharedUpdate& update = arrived.update;
  if (update.restart) Restart();
  for (size_t i = 0; i < update.keyframes.size(); ++i) {
    TakeKeyframe(update.keyframes[i], arrived.words[i]);
  }
  for (const SharedMapPoint& point : update.points) {
    if (Takes(point.id.local_map)) TakePoint(point);
  }
  for (const SharedKeyframeMove& move : update.moved_keyframes) {
    ForeignKeyframe* keyframe = keyframes_.Find(move.id);
    if (keyframe == nullptr) continue;
    keyframe->camera_from_global = move.camera_from_global;
    news_[move.id.local_map].keyframes.insert(move.id);
  }
  for (const SharedMapPointMove& move : update.moved_points) {
    SharedMapPoint* point = points_.Find(move.id);
    if (point == nullptr) continue;
    point->position_in_global = move.position_in_global;
    MarkPoint(move.id);
  }
  for (const ObservationChange& change : update.observations) TakeObservation(change);
  for (const Landmark& landmark : update.landmarks) TakeLandmark(landmark);
  for (const OwnKeyframePose& pose : update.own_keyframes) own_places_.Tell(pose);
  for (const KeyframeId& id : update.removed_keyframes) RemoveKeyframe(id);
  for (const MapPointId& id : update.removed_points) RemovePoint(id);
}

void SharedContent::LeaveOut(LocalMapId local_map) {
  left_out_.insert(local_map);
  std::vector<KeyframeId> gone_keyframes;
  for (const auto& [id, keyframe] : keyframes()) {
    if (id.local_map == local_map) gone_keyframes.push_back(id);
  }
  std::vector<MapPointId> gone_points;
  for (const auto& [id, point] : points()) {
    if (id.local_map == local_map) gone_points.push_back(id);
  }
  for (const KeyframeId id : gone_keyframes) RemoveKeyframe(id);
  for (const MapPointId id : gone_points) {
    points_.Erase(id);
    MarkPoint(id);
  }
}

void SharedContent::Restart() {
  for (const auto& [id, keyframe] : keyframes()) news_[id.local_map].keyframes.insert(id);
  for (const auto& [id, point] : points()) MarkPoint(id);
  keyframes_ = {};
  points_ = {};
  own_places_.ForgetAll();
  survivor_of_.clear();
  members_of_.clear();
  viewers_of_.clear();
}

void SharedContent::TakePoint(const SharedMapPoint& point) {
  if (SharedMapPoint* known = points_.Find(point.id)) {
    *known = point;
  } else {
    points_.Add(point.id, point);
  }
  MarkPoint(point.id);
}

void SharedContent::TakeKeyframe(const SharedKeyframe& shared, std::shared_ptr<const Words> words) {
  const KeyframeId id = shared.payload->id;
  if (!Takes(id.local_map)) return;
  RemoveKeyframe(id);
  keyframes_.Add(id, {shared.payload, std::move(words), shared.camera_from_global, shared.parent,
                      shared.points});
  for (const MapPointId& point : shared.points) ListViewer(point, id);
  news_[id.local_map].keyframes.insert(id);
  news_[id.local_map].sights.insert(id);
}

void SharedContent::TakeObservation(const ObservationChange& change) {
  ForeignKeyframe* keyframe = keyframes_.Find(change.keyframe);
  if (keyframe == nullptr || change.keypoint >= keyframe->points.size()) return;
  MapPointId& seen = keyframe->points[change.keypoint];
  UnlistViewer(seen, change.keyframe);
  seen = change.kind == ObservationChange::Kind::kAdded ? change.point : MapPointId();
  ListViewer(seen, change.keyframe);
  news_[change.keyframe.local_map].sights.insert(change.keyframe);
}

// Takes in a landmark, which is told as a whole: a point that is not named any more does not belong
// to it. The store assumes that members are not kept here, and tells them in full where they become
// a landmark's survivors again.
void SharedContent::TakeLandmark(const Landmark& landmark) {
  const MapPointId survivor = landmark.survivor;
  DissolveLandmark(survivor);
  LeaveLandmark(survivor);
  for (const MapPointId& member : landmark.members) {
    DissolveLandmark(member);
    survivor_of_[member] = survivor;
    if (member.local_map != own_) points_.Erase(member);
    MarkPoint(member);
  }
  members_of_[survivor] = landmark.members;
  MarkPoint(survivor);
  MarkViewers(survivor);
}

void SharedContent::LeaveLandmark(MapPointId member) {
  const auto it = survivor_of_.find(member);
  if (it == survivor_of_.end()) return;
  const MapPointId survivor = it->second;
  MarkPoint(survivor);
  MarkViewers(survivor);
  std::erase(members_of_[survivor], member);
  survivor_of_.erase(it);
}

void SharedContent::DissolveLandmark(MapPointId survivor) {
  const auto it = members_of_.find(survivor);
  if (it == members_of_.end()) return;
  for (const MapPointId& member : it->second) {
    MarkPoint(member);
    const auto of = survivor_of_.find(member);
    if (of != survivor_of_.end() && of->second == survivor) survivor_of_.erase(of);
  }
  members_of_.erase(it);
}

void SharedContent::RemoveKeyframe(KeyframeId id) {
  const ForeignKeyframe* keyframe = FindKeyframe(id);
  if (keyframe == nullptr) return;
  for (const MapPointId& point : keyframe->points) UnlistViewer(point, id);
  keyframes_.Erase(id);
  news_[id.local_map].keyframes.insert(id);
}

void SharedContent::RemovePoint(MapPointId id) {
  points_.Erase(id);
  DissolveLandmark(id);
  MarkPoint(id);
}

void SharedContent::ListViewer(MapPointId point, KeyframeId viewer) {
  if (!point.IsValid()) return;
  std::vector<KeyframeId>& viewers = viewers_of_[point];
  viewers.push_back(viewer);
  if (MayHold(viewer, point, viewers)) MarkPoint(point);
}

void SharedContent::UnlistViewer(MapPointId point, KeyframeId viewer) {
  const auto it = viewers_of_.find(point);
  if (it == viewers_of_.end()) return;
  if (MayHold(viewer, point, it->second)) MarkPoint(point);
  const auto listed = std::ranges::find(it->second, viewer);
  if (listed != it->second.end()) it->second.erase(listed);
  if (it->second.empty()) viewers_of_.erase(it);
}

bool SharedContent::MayHold(KeyframeId viewer, MapPointId point,
                            const std::vector<KeyframeId>& viewers) const {
  const SharedMapPoint* shared = FindPoint(point);
  return shared != nullptr && (shared->reference == viewer || viewers.front() == viewer);
}

void SharedContent::MarkPoint(MapPointId id) {
  if (id.local_map != own_) news_[id.local_map].points.insert(id);
}

void SharedContent::MarkViewersOf(MapPointId id) {
  const auto it = viewers_of_.find(id);
  if (it == viewers_of_.end()) return;
  for (const KeyframeId& viewer : it->second) news_[viewer.local_map].sights.insert(viewer);
}

void SharedContent::MarkViewers(MapPointId id) {
  const MapPointId survivor = SurvivorOf(id);
  MarkViewersOf(survivor);
  const auto it = members_of_.find(survivor);
  if (it == members_of_.end()) return;
  for (const MapPointId& member : it->second) MarkViewersOf(member);
}

MapPointId SharedContent::SurvivorOf(MapPointId id) const {
  const auto it = survivor_of_.find(id);
  return it == survivor_of_.end() ? id : it->second;
}

KeyframeId SharedContent::PlacingKeyframeOf(const SharedMapPoint& point) const {
  if (FindKeyframe(point.reference) != nullptr) return point.reference;
  const auto it = viewers_of_.find(point.id);
  return it == viewers_of_.end() ? KeyframeId() : it->second.front();
}

MapPointId SharedContent::Representative(const Map& map, MapPointId id) const {
  const MapPointId survivor = SurvivorOf(id);
  if (survivor.local_map == own_ && map.FindPoint(survivor) != nullptr) return survivor;
  const auto it = members_of_.find(survivor);
  if (it == members_of_.end()) return survivor;
  for (const MapPointId& member : it->second) {
    if (member.local_map == own_ && map.FindPoint(member) != nullptr) return member;
  }
  return survivor;
}

}  // namespace corbslam::client_agent

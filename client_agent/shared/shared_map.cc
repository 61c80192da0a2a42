#include "client_agent/shared/shared_map.h"

#include <utility>

namespace corbslam::client_agent {

void SharedMap::Apply(const ArrivedUpdate& arrived) {
  content_.Apply(arrived);
  has_all_places_ = !arrived.update.more_places;
  const SharedUpdate& update = arrived.update;
  apart_ = update.apart;
  in_metres_ = update.in_metres;
  if (update.restart) told_global_from_local_.reset();
  if (update.global_from_local.has_value()) told_global_from_local_ = update.global_from_local;
  // What is said of the local map as a whole is older than its keyframes' places.
  if (!update.own_keyframes.empty()) told_global_from_local_.reset();
}

std::optional<Similarity3d> SharedMap::GlobalFromLocal() const {
  if (apart_) return std::nullopt;
  const auto& places = content_.own_places().places();
  if (places.empty()) return told_global_from_local_;
  return places.rbegin()->second.GlobalFromLocal();
}

void SharedMap::Correct(const OwnCorrection& correction, Map& map) {
  content_.own_places().Correct(correction);
  for (const auto& [id, placing] : planner_.placings()) {
    if (map.FindKeyframe(id) == nullptr || correction.fixed.contains(id)) continue;
    const auto motion = correction.motions.find(planner_.pinned().PinOf(id));
    if (motion == correction.motions.end()) continue;
    const Rigid3d after_from_before = motion->second.AfterFromBefore();
    planner_.Move(id, after_from_before);
    MoveWithPoints(id, after_from_before, map);
  }
}

namespace {

// Returns whether own keyframes say where the point is: two of them see it, or one with its depth.
bool IsLocatedBy(LocalMapId own, const MapPoint& point, const Map& map) {
  int sights = 0;
  for (auto it = point.observations.lower_bound({own, 0});
       it != point.observations.end() && it->first.local_map == own; ++it) {
    sights += map.FindKeyframe(it->first)->keypoints()[it->second].HasDepth() ? 2 : 1;
  }
  return sights >= 2;
}

}  // namespace

void SharedMap::LeaveOut(LocalMapId local_map, const std::function<MapPointId()>& new_name,
                         Map& map) {
  std::vector<MapPointId> located;
  for (const auto& [id, point] : map.points()) {
    if (id.local_map != local_map) continue;
    if (IsLocatedBy(own_, point, map)) located.push_back(id);
    for (const auto& [viewer, keypoint] : point.observations) {
      if (viewer.local_map == own_) released_.insert(viewer);
    }
  }
  for (const MapPointId id : located) {
    MapPoint point;
    point.id = new_name();
    point.position_in_map = map.FindPoint(id)->position_in_map;
    const MapPointId name = point.id;
    map.AddPoint(std::move(point));
    map.ReplacePoint(id, name);
    map.UpdatePointAppearance(name);
  }
  content_.LeaveOut(local_map);
}

void SharedMap::MoveWithPoints(KeyframeId id, const Rigid3d& after_from_before, Map& map) const {
  const Keyframe& keyframe = *map.FindKeyframe(id);
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> positions;
  for (const MapPointId& seen : keyframe.points) {
    const MapPoint* point = seen.IsValid() ? map.FindPoint(seen) : nullptr;
    if (point == nullptr || seen.local_map == own_) continue;
    const SharedMapPoint* shared = content_.FindPoint(seen);
    if (shared == nullptr || content_.PlacingKeyframeOf(*shared) != id) continue;
    positions.emplace_back(seen, after_from_before * point->position_in_map);
  }
  map.SetPose(id, keyframe.camera_from_map * after_from_before.Inverse());
  for (const auto& [point, position] : positions) map.SetPosition(point, position);
}

PlacementPlan SharedMap::Plan(const Map& map) {
  if (!has_all_places_) return {};
  content_.own_places().ForgetGone(map);
  if (!CanPlace()) return {};
  std::optional<Rigid3d> local_from_global;
  if (told_global_from_local_.has_value()) {
    local_from_global = told_global_from_local_->ToRigid().Inverse();
  }
  return planner_.Plan(map, content_, local_from_global);
}

PlacementChange SharedMap::Place(const PlacementPlan& plan, Map& map) {
  PlacementChange change;
  if (!has_all_places_) return change;
  change.released_keyframes.assign(released_.begin(), released_.end());
  released_.clear();
  for (const auto& [source, news] : content_.news()) RemoveGoneKeyframes(news, map, change);
  for (const auto& placed : plan.keyframes) PlaceKeyframe(placed, map, change);
  for (const auto& placed : plan.points) PlacePoint(placed, map);
  for (const auto& [source, news] : content_.news()) DropPoints(news, map);
  for (auto& [source, news] : content_.news()) {
    for (const KeyframeId id : news.sights) PlaceSights(id, map);
    // Items that can't be placed yet stay news until they can.
    if (CanPlace()) {
      news = SourceNews();
    } else {
      ForgetGone(news);
    }
  }
  if (!change.added_keyframes.empty()) HangOrphans(map);
  return change;
}

void SharedMap::ForgetGone(SourceNews& news) const {
  const auto is_gone = [this](KeyframeId id) { return content_.FindKeyframe(id) == nullptr; };
  absl::erase_if(news.keyframes, is_gone);
  absl::erase_if(news.sights, is_gone);
  absl::erase_if(news.points, [this](MapPointId id) { return content_.FindPoint(id) == nullptr; });
}

void SharedMap::RemoveGoneKeyframes(const SourceNews& news, Map& map, PlacementChange& change) {
  for (const KeyframeId id : news.keyframes) {
    if (content_.FindKeyframe(id) != nullptr) continue;
    planner_.Forget(id);
    if (map.RemoveKeyframe(id)) change.removed_keyframes.push_back(id);
  }
}

void SharedMap::PlaceKeyframe(const PlacementPlan::PlacedKeyframe& placed, Map& map,
                              PlacementChange& change) {
  const ForeignKeyframe& shared = *placed.shared;
  if (map.FindKeyframe(placed.id) != nullptr) {
    map.SetPose(placed.id, placed.camera_from_local);
  } else {
    Keyframe keyframe;
    keyframe.payload = shared.payload;
    keyframe.words = shared.words;
    keyframe.camera_from_map = placed.camera_from_local;
    map.AddKeyframe(std::move(keyframe));
    change.added_keyframes.push_back(placed.id);
  }
  if (shared.parent.IsValid() && !map.SetParent(placed.id, shared.parent)) {
    orphans_.insert(placed.id);
  }
}

void SharedMap::HangOrphans(Map& map) {
  absl::erase_if(orphans_, [&](KeyframeId id) {
    const ForeignKeyframe* keyframe = content_.FindKeyframe(id);
    return keyframe == nullptr || map.SetParent(id, keyframe->parent);
  });
}

void SharedMap::PlacePoint(const PlacementPlan::PlacedPoint& placed, Map& map) {
  const SharedMapPoint& shared = *placed.shared;
  if (map.FindPoint(shared.id) == nullptr) {
    MapPoint point;
    point.id = shared.id;
    point.position_in_map = placed.position_in_local;
    map.AddPoint(std::move(point));
    content_.MarkViewers(shared.id);
  } else {
    map.SetPosition(shared.id, placed.position_in_local);
  }
  map.SetPointAppearance(shared.id, shared.descriptor, placed.normal_in_local, shared.min_distance,
                         shared.max_distance, shared.reference);
}

void SharedMap::DropPoints(const SourceNews& news, Map& map) const {
  for (const MapPointId id : news.points) {
    if (map.FindPoint(id) == nullptr) continue;
    const MapPointId representative = content_.Representative(map, id);
    if (representative == id && content_.FindPoint(id) != nullptr) continue;
    if (!map.ReplacePoint(id, representative)) map.RemovePoint(id);
  }
}

void SharedMap::PlaceSights(KeyframeId id, Map& map) const {
  const ForeignKeyframe* shared = content_.FindKeyframe(id);
  const Keyframe* keyframe = map.FindKeyframe(id);
  if (shared == nullptr || keyframe == nullptr) return;
  std::vector<MapPointId> wanted = shared->points;
  for (uint32_t k = 0; k < wanted.size(); ++k) {
    if (wanted[k].IsValid()) wanted[k] = content_.Representative(map, wanted[k]);
    const MapPointId held = keyframe->points[k];
    if (held.IsValid() && held != wanted[k]) map.RemoveObservation(held, id);
  }
  for (uint32_t k = 0; k < wanted.size(); ++k) {
    if (wanted[k].IsValid()) map.AddObservation(wanted[k], id, k);
  }
}

}  // namespace corbslam::client_agent

#include "client_agent/memory/shared_map.h"

#include <utility>

#include "client_agent/memory/visual_contact.h"

namespace corbslam {
namespace {

// A keyframe whose placing differs by less is left where it is: that is below what tracking can
// see.
constexpr double kSmallestMotion_m = 1e-4;
constexpr double kSmallestTurn_rad = 1e-5;

bool HasMoved(const Rigid3d& before, const Rigid3d& now) {
  const Rigid3d motion = now * before.Inverse();
  return motion.translation.norm() > kSmallestMotion_m ||
         RotationAngle(motion.rotation) > kSmallestTurn_rad;
}

Rigid3d LocalFromGlobal(const Rigid3d& camera_from_local, const Similarity3d& camera_from_global) {
  return camera_from_local.Inverse() * camera_from_global.ToRigid();
}

Rigid3d CameraFromLocal(const Similarity3d& camera_from_global, const Rigid3d& local_from_global) {
  return camera_from_global.ToRigid() * local_from_global.Inverse();
}

template <typename Id, typename Item, typename F>
void ForEachKnown(const absl::btree_set<Id>& ids, const std::map<Id, Item>& items, F&& f) {
  for (const Id& id : ids) {
    if (const auto it = items.find(id); it != items.end()) f(id, it->second);
  }
}

}  // namespace

std::optional<Similarity3d> SharedMap::GlobalFromLocal() const {
  const auto& places = content_.own_places().places();
  if (places.empty()) return std::nullopt;
  return Similarity3d::FromRigid(places.rbegin()->second.LocalFromGlobal().Inverse());
}

void SharedMap::Correct(const OwnCorrection& correction, Map& map) {
  content_.own_places().Correct(correction);
  for (auto& [id, local_from_global] : placings_) {
    const Keyframe* foreign = map.FindKeyframe(id);
    if (foreign == nullptr || correction.held.contains(id)) continue;
    const auto motion = correction.motions.find(MostSharing(*foreign, own_));
    if (motion == correction.motions.end()) continue;
    const Rigid3d after_from_before = motion->second.AfterFromBefore();
    local_from_global = after_from_before * local_from_global;
    MoveWithPoints(id, after_from_before, map);
  }
}

void SharedMap::MoveWithPoints(KeyframeId id, const Rigid3d& after_from_before, Map& map) const {
  const Keyframe& keyframe = *map.FindKeyframe(id);
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> positions;
  for (const MapPointId& seen : keyframe.points) {
    const MapPoint* point = seen.IsValid() ? map.FindPoint(seen) : nullptr;
    if (point == nullptr || seen.local_map == own_) continue;
    const auto shared = content_.points().find(seen);
    if (shared == content_.points().end() || content_.HolderOf(shared->second) != id) continue;
    positions.emplace_back(seen, after_from_before * point->position_in_map);
  }
  map.SetPose(id, keyframe.camera_from_map * after_from_before.Inverse());
  for (const auto& [point, position] : positions) map.SetPosition(point, position);
}

PlacementChange SharedMap::Place(Map& map) {
  PlacementChange change;
  if (!has_all_places_) return change;
  content_.own_places().ForgetGone(map);
  for (const auto& [source, news] : content_.news()) RemoveGoneKeyframes(news, map, change);
  const bool can_place = !content_.own_places().places().empty();
  if (can_place) PlaceKeyframes(map, change);
  for (const auto& [source, news] : content_.news()) DropPoints(news, map);
  for (auto& [source, news] : content_.news()) {
    for (const KeyframeId id : news.sights) PlaceSights(id, map);
    // What could not be placed is still news when it can.
    if (can_place) {
      news = SourceNews();
    } else {
      ForgetGone(news);
    }
  }
  if (!change.added_keyframes.empty()) HangOrphans(map);
  return change;
}

void SharedMap::ForgetGone(SourceNews& news) const {
  const auto is_gone = [this](KeyframeId id) { return !content_.keyframes().contains(id); };
  absl::erase_if(news.keyframes, is_gone);
  absl::erase_if(news.sights, is_gone);
  absl::erase_if(news.points, [this](MapPointId id) { return !content_.points().contains(id); });
}

void SharedMap::RemoveGoneKeyframes(const SourceNews& news, Map& map, PlacementChange& change) {
  for (const KeyframeId id : news.keyframes) {
    if (content_.keyframes().contains(id)) continue;
    placings_.erase(id);
    if (map.RemoveKeyframe(id)) change.removed_keyframes.push_back(id);
  }
}

std::map<KeyframeId, Rigid3d> SharedMap::FindHeld(const Map& map) const {
  std::map<KeyframeId, Rigid3d> held;
  for (const auto& [id, foreign] : content_.keyframes()) {
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr) continue;
    const Keyframe* own = map.FindKeyframe(MostSharing(*keyframe, own_));
    if (own == nullptr || !AgreeOnSharedPoints(map, *keyframe, *own)) continue;
    held[id] = LocalFromGlobal(keyframe->camera_from_map, foreign.camera_from_global);
  }
  return held;
}

// Where own keyframes share points with those that stay, these say more: fusion may have placed the
// own ones by what it knew before it looked at the points.
PlacingAnchors SharedMap::ChooseAnchors(const Map& map,
                                        const std::map<KeyframeId, Rigid3d>& held) const {
  PlacingAnchors anchors;
  absl::btree_set<KeyframeId> superseded;
  for (const auto& [id, local_from_global] : held) {
    anchors.Add(content_.keyframes().at(id).camera_from_global.ToRigid(), local_from_global);
    for (const CovisibleKeyframe& sharing : map.Covisible(id)) {
      if (sharing.id.local_map == own_) superseded.insert(sharing.id);
    }
  }
  for (const auto& [id, place] : content_.own_places().places()) {
    if (superseded.contains(id)) continue;
    anchors.Add(place.camera_from_global, place.LocalFromGlobal());
  }
  return anchors;
}

void SharedMap::PlaceKeyframes(Map& map, PlacementChange& change) {
  const std::map<KeyframeId, Rigid3d> held = FindHeld(map);
  anchors_ = ChooseAnchors(map, held);
  std::vector<KeyframeId> moved;
  for (const auto& [id, foreign] : content_.keyframes()) {
    const auto stays = held.find(id);
    const Rigid3d local_from_global =
        stays != held.end()
            ? stays->second
            : anchors_.LocalFromGlobalAt(CameraCentre(foreign.camera_from_global.ToRigid()));
    const auto [placing, is_new] = placings_.try_emplace(id, local_from_global);
    const bool has_moved = !is_new && HasMoved(placing->second, local_from_global);
    if (has_moved) placing->second = local_from_global;
    if (has_moved || is_new) moved.push_back(id);
    const auto news = content_.news().find(id.local_map);
    const bool is_news = news != content_.news().end() && news->second.keyframes.contains(id);
    if (has_moved || is_new || is_news) PlaceKeyframe(id, foreign, map, change);
  }
  PlacePoints(moved, map);
}

void SharedMap::PlacePoints(const std::vector<KeyframeId>& moved, Map& map) {
  const auto place_point = [&](MapPointId id, const SharedMapPoint& shared) {
    PlacePoint(id, shared, map);
  };
  absl::erase_if(points_alone_, [this](MapPointId id) { return !content_.points().contains(id); });
  ForEachKnown(absl::btree_set<MapPointId>(points_alone_), content_.points(), place_point);
  for (const auto& [source, news] : content_.news()) {
    ForEachKnown(news.points, content_.points(), place_point);
  }
  for (const KeyframeId id : moved) PlacePointsOf(id, content_.keyframes().at(id), map);
}

void SharedMap::PlaceKeyframe(KeyframeId id, const ForeignKeyframe& foreign, Map& map,
                              PlacementChange& change) {
  const Rigid3d camera_from_local = CameraFromLocal(foreign.camera_from_global, placings_.at(id));
  if (map.FindKeyframe(id) != nullptr) {
    map.SetPose(id, camera_from_local);
  } else {
    Keyframe keyframe;
    keyframe.payload = foreign.payload;
    keyframe.words = foreign.words;
    keyframe.camera_from_map = camera_from_local;
    map.AddKeyframe(std::move(keyframe));
    change.added_keyframes.push_back(id);
  }
  if (foreign.parent.IsValid() && !map.SetParent(id, foreign.parent)) orphans_.insert(id);
}

void SharedMap::PlacePointsOf(KeyframeId id, const ForeignKeyframe& foreign, Map& map) {
  for (const MapPointId& point : foreign.points) {
    const auto it = content_.points().find(point);
    if (it == content_.points().end() || content_.HolderOf(it->second) != id) continue;
    PlacePoint(point, it->second, map);
  }
}

void SharedMap::HangOrphans(Map& map) {
  absl::erase_if(orphans_, [&](KeyframeId id) {
    const auto it = content_.keyframes().find(id);
    return it == content_.keyframes().end() || map.SetParent(id, it->second.parent);
  });
}

void SharedMap::PlacePoint(MapPointId id, const SharedMapPoint& shared, Map& map) {
  if (content_.Representative(map, id) != id) return;
  const Rigid3d local_from_global = PlacingOf(shared);
  const Eigen::Vector3d position = local_from_global * shared.position_in_global;
  if (map.FindPoint(id) == nullptr) {
    MapPoint point;
    point.id = id;
    point.position_in_map = position;
    map.AddPoint(std::move(point));
    content_.MarkViewers(id);
  } else {
    map.SetPosition(id, position);
  }
  map.SetPointAppearance(id, shared.descriptor,
                         local_from_global.rotation * shared.normal_in_global, shared.min_distance,
                         shared.max_distance, shared.reference);
}

Rigid3d SharedMap::PlacingOf(const SharedMapPoint& point) {
  const auto placing = placings_.find(content_.HolderOf(point));
  if (placing != placings_.end()) {
    points_alone_.erase(point.id);
    return placing->second;
  }
  points_alone_.insert(point.id);
  return anchors_.LocalFromGlobalAt(point.position_in_global);
}

void SharedMap::DropPoints(const SourceNews& news, Map& map) const {
  for (const MapPointId id : news.points) {
    if (map.FindPoint(id) == nullptr) continue;
    const MapPointId representative = content_.Representative(map, id);
    if (representative == id && content_.points().contains(id)) continue;
    if (!map.ReplacePoint(id, representative)) map.RemovePoint(id);
  }
}

void SharedMap::PlaceSights(KeyframeId id, Map& map) const {
  const auto it = content_.keyframes().find(id);
  const Keyframe* keyframe = map.FindKeyframe(id);
  if (it == content_.keyframes().end() || keyframe == nullptr) return;
  std::vector<MapPointId> wanted = it->second.points;
  for (uint32_t k = 0; k < wanted.size(); ++k) {
    if (wanted[k].IsValid()) wanted[k] = content_.Representative(map, wanted[k]);
    const MapPointId held = keyframe->points[k];
    if (held.IsValid() && held != wanted[k]) map.RemoveObservation(held, id);
  }
  for (uint32_t k = 0; k < wanted.size(); ++k) {
    if (wanted[k].IsValid()) map.AddObservation(wanted[k], id, k);
  }
}

}  // namespace corbslam

#include "client_agent/memory/shared_map.h"

#include <limits>
#include <utility>

#include "absl/container/btree_set.h"

namespace corbslam {
namespace {

// A source whose place differs by less is left where it is: that is below what tracking can see.
constexpr double kSmallestMotion_m = 1e-4;
constexpr double kSmallestTurn_rad = 1e-5;

bool HasMoved(const Rigid3d& before, const Rigid3d& now) {
  const Rigid3d motion = now * before.Inverse();
  return motion.translation.norm() > kSmallestMotion_m ||
         RotationAngle(motion.rotation) > kSmallestTurn_rad;
}

Rigid3d CameraFromLocal(const Similarity3d& camera_from_global, const Rigid3d& local_from_global) {
  return camera_from_global.ToRigid() * local_from_global.Inverse();
}

template <typename Id, typename Item, typename F>
void ForEachOf(const std::map<Id, Item>& items, LocalMapId source, F&& f) {
  for (auto it = items.lower_bound({source, 0}); it != items.end() && it->first.local_map == source;
       ++it) {
    f(it->first, it->second);
  }
}

template <typename Id, typename Item, typename F>
void ForEachKnown(const absl::btree_set<Id>& ids, const std::map<Id, Item>& items, F&& f) {
  for (const Id& id : ids) {
    if (const auto it = items.find(id); it != items.end()) f(id, it->second);
  }
}

}  // namespace

KeyframeId SharedMap::MostCovisible(const Map& map, LocalMapId source) const {
  KeyframeId best;
  int best_weight = 0;
  for (const auto& [id, camera_from_global] : content_.own_keyframes()) {
    const Keyframe* own = map.FindKeyframe(id);
    if (own == nullptr) continue;
    int weight = 0;
    for (const auto& [other, shared] : own->covisible) {
      if (other.local_map == source) weight += shared;
    }
    if (weight <= best_weight) continue;
    best = id;
    best_weight = weight;
  }
  return best;
}

KeyframeId SharedMap::Nearest(const Map& map, LocalMapId source) const {
  std::vector<Eigen::Vector3d> centres;
  ForEachOf(content_.keyframes(), source, [&](KeyframeId, const ForeignKeyframe& keyframe) {
    centres.push_back(CameraCentre(keyframe.camera_from_global.ToRigid()));
  });
  KeyframeId best;
  double best_distance2 = std::numeric_limits<double>::infinity();
  for (const auto& [id, camera_from_global] : content_.own_keyframes()) {
    if (map.FindKeyframe(id) == nullptr) continue;
    // Of a source there may be points alone, which others' keyframes see.
    if (centres.empty()) return id;
    const Eigen::Vector3d own = CameraCentre(camera_from_global.ToRigid());
    for (const Eigen::Vector3d& centre : centres) {
      const double distance2 = (centre - own).squaredNorm();
      if (distance2 >= best_distance2) continue;
      best = id;
      best_distance2 = distance2;
    }
  }
  return best;
}

Rigid3d SharedMap::LocalFromGlobal(const Map& map, KeyframeId anchor) const {
  const Rigid3d camera_from_local = map.FindKeyframe(anchor)->camera_from_map;
  return camera_from_local.Inverse() * content_.own_keyframes().at(anchor).ToRigid();
}

std::optional<Similarity3d> SharedMap::GlobalFromLocal(const Map& map) const {
  const auto& own = content_.own_keyframes();
  for (auto it = own.rbegin(); it != own.rend(); ++it) {
    if (map.FindKeyframe(it->first) == nullptr) continue;
    return Similarity3d::FromRigid(LocalFromGlobal(map, it->first).Inverse());
  }
  return std::nullopt;
}

PlacementChange SharedMap::Place(Map& map) {
  PlacementChange change;
  absl::btree_set<LocalMapId> placed;
  for (const auto& [source, news] : content_.news()) RemoveGoneKeyframes(news, map, change);
  for (const auto& [source, news] : content_.news()) {
    if (PlaceSource(source, news, map, change)) placed.insert(source);
  }
  for (const auto& [source, news] : content_.news()) DropPoints(news, map);
  for (auto& [source, news] : content_.news()) {
    for (const KeyframeId id : news.sights) PlaceSights(id, map);
    // What could not be placed is still news when it can.
    if (placed.contains(source)) {
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

void SharedMap::RemoveGoneKeyframes(const SourceNews& news, Map& map,
                                    PlacementChange& change) const {
  for (const KeyframeId id : news.keyframes) {
    if (content_.keyframes().contains(id) || !map.RemoveKeyframe(id)) continue;
    change.removed_keyframes.push_back(id);
  }
}

bool SharedMap::PlaceSource(LocalMapId source, const SourceNews& news, Map& map,
                            PlacementChange& change) {
  KeyframeId anchor = MostCovisible(map, source);
  if (!anchor.IsValid()) anchor = Nearest(map, source);
  if (!anchor.IsValid()) return false;
  const Rigid3d local_from_global = LocalFromGlobal(map, anchor);
  const auto placing = placings_.find(source);
  if (placing == placings_.end() || HasMoved(placing->second, local_from_global)) {
    placings_[source] = local_from_global;
    PlaceEverything(source, map, change);
    return true;
  }
  const auto place_keyframe = [&](KeyframeId id, const ForeignKeyframe& foreign) {
    PlaceKeyframe(id, foreign, map, change);
  };
  const auto place_point = [&](MapPointId id, const SharedMapPoint& shared) {
    PlacePoint(id, shared, map);
  };
  ForEachKnown(news.keyframes, content_.keyframes(), place_keyframe);
  ForEachKnown(news.points, content_.points(), place_point);
  return true;
}

void SharedMap::PlaceEverything(LocalMapId source, Map& map, PlacementChange& change) {
  ForEachOf(content_.keyframes(), source, [&](KeyframeId id, const ForeignKeyframe& foreign) {
    PlaceKeyframe(id, foreign, map, change);
  });
  ForEachOf(content_.points(), source,
            [&](MapPointId id, const SharedMapPoint& shared) { PlacePoint(id, shared, map); });
}

void SharedMap::PlaceKeyframe(KeyframeId id, const ForeignKeyframe& foreign, Map& map,
                              PlacementChange& change) {
  const Rigid3d camera_from_local =
      CameraFromLocal(foreign.camera_from_global, placings_.at(id.local_map));
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

void SharedMap::HangOrphans(Map& map) {
  absl::erase_if(orphans_, [&](KeyframeId id) {
    const auto it = content_.keyframes().find(id);
    return it == content_.keyframes().end() || map.SetParent(id, it->second.parent);
  });
}

void SharedMap::PlacePoint(MapPointId id, const SharedMapPoint& shared, Map& map) {
  if (content_.Representative(map, id) != id) return;
  const Rigid3d& local_from_global = placings_.at(id.local_map);
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

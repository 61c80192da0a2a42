#include "client_agent/memory/shared_map.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

namespace corbslam {
namespace {

// A placing that moves less than this is left alone: it is below what tracking can see.
constexpr double kSmallestMotion_m = 1e-4;
constexpr double kSmallestTurn_rad = 1e-5;

Rigid3d CameraFromLocal(const Similarity3d& camera_from_global, const Rigid3d& local_from_global) {
  return camera_from_global.ToRigid() * local_from_global.Inverse();
}

}  // namespace

SharedMap::SharedMap(LocalMapId own, ComputeWords compute_words)
    : own_(own), compute_words_(std::move(compute_words)) {}

void SharedMap::Apply(const SharedUpdate& update) {
  if (update.restart) {
    keyframes_.clear();
    points_.clear();
    survivor_of_.clear();
    own_members_.clear();
    own_from_global_.clear();
    placings_.clear();
  }
  for (const SharedKeyframe& keyframe : update.keyframes) {
    const KeyframeId id = keyframe.payload->id;
    if (id.local_map == own_) continue;
    keyframes_[id] = {keyframe.payload, compute_words_(keyframe.payload->features.descriptors),
                      keyframe.camera_from_global, keyframe.parent, keyframe.points};
    MarkChanged(id.local_map);
  }
  for (const SharedMapPoint& point : update.points) {
    if (point.id.local_map == own_) continue;
    points_[point.id] = point;
    MarkChanged(point.id.local_map);
  }
  for (const SharedKeyframeMove& move : update.moved_keyframes) {
    const auto it = keyframes_.find(move.id);
    if (it == keyframes_.end()) continue;
    it->second.camera_from_global = move.camera_from_global;
    MarkChanged(move.id.local_map);
  }
  for (const SharedMapPointMove& move : update.moved_points) {
    const auto it = points_.find(move.id);
    if (it == points_.end()) continue;
    it->second.position_in_global = move.position_in_global;
    MarkChanged(move.id.local_map);
  }
  for (const ObservationChange& change : update.observations) ApplyObservation(change);
  for (const Landmark& landmark : update.landmarks) {
    auto& own_members = own_members_[landmark.survivor];
    own_members.clear();
    for (const MapPointId& member : landmark.members) {
      survivor_of_[member] = landmark.survivor;
      if (member.local_map == own_) own_members.push_back(member);
      MarkChanged(member.local_map);
    }
    MarkChanged(landmark.survivor.local_map);
  }
  for (const OwnKeyframePose& pose : update.own_keyframes) {
    own_from_global_[pose.id] = pose.camera_from_global;
  }
  for (const KeyframeId& id : update.removed_keyframes) {
    keyframes_.erase(id);
    own_from_global_.erase(id);
  }
  for (const MapPointId& id : update.removed_points) points_.erase(id);
}

void SharedMap::ApplyObservation(const ObservationChange& change) {
  const auto it = keyframes_.find(change.keyframe);
  if (it == keyframes_.end() || change.keypoint >= it->second.points.size()) return;
  const bool added = change.kind == ObservationChange::Kind::kAdded;
  it->second.points[change.keypoint] = added ? change.point : MapPointId();
  MarkChanged(change.keyframe.local_map);
}

MapPointId SharedMap::Representative(const Map& map, MapPointId id) const {
  const auto survivor = survivor_of_.find(id);
  if (survivor != survivor_of_.end()) id = survivor->second;
  if (id.local_map == own_ && map.FindPoint(id) != nullptr) return id;
  const auto own = own_members_.find(id);
  if (own != own_members_.end()) {
    for (const MapPointId& member : own->second) {
      if (map.FindPoint(member) != nullptr) return member;
    }
  }
  return id;
}

KeyframeId SharedMap::MostCovisible(const Map& map, LocalMapId source) const {
  KeyframeId best;
  int best_weight = 0;
  for (const auto& [id, camera_from_global] : own_from_global_) {
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
  KeyframeId best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (const auto& [id, camera_from_global] : own_from_global_) {
    if (map.FindKeyframe(id) == nullptr) continue;
    const Eigen::Vector3d centre = CameraCentre(camera_from_global.ToRigid());
    double distance = std::numeric_limits<double>::infinity();
    for (auto it = keyframes_.lower_bound({source, 0});
         it != keyframes_.end() && it->first.local_map == source; ++it) {
      const Eigen::Vector3d other = CameraCentre(it->second.camera_from_global.ToRigid());
      distance = std::min(distance, (other - centre).norm());
    }
    if (distance >= best_distance) continue;
    best = id;
    best_distance = distance;
  }
  return best;
}

Rigid3d SharedMap::LocalFromGlobal(const Map& map, KeyframeId anchor) const {
  const Rigid3d camera_from_local = map.FindKeyframe(anchor)->camera_from_map;
  return camera_from_local.Inverse() * own_from_global_.at(anchor).ToRigid();
}

std::optional<Similarity3d> SharedMap::GlobalFromLocal(const Map& map) const {
  for (auto it = own_from_global_.rbegin(); it != own_from_global_.rend(); ++it) {
    if (map.FindKeyframe(it->first) == nullptr) continue;
    return Similarity3d::FromRigid(LocalFromGlobal(map, it->first).Inverse());
  }
  return std::nullopt;
}

void SharedMap::RemoveGone(Map& map, PlacementChange& change) {
  std::vector<MapPointId> gone_points;
  for (const auto& [id, point] : map.points()) {
    if (id.local_map != own_ && !points_.contains(id)) gone_points.push_back(id);
  }
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id.local_map != own_ && !keyframes_.contains(id)) {
      change.removed_keyframes.push_back(id);
    }
  }
  for (const MapPointId& id : gone_points) map.RemovePoint(id);
  for (const KeyframeId& id : change.removed_keyframes) map.RemoveKeyframe(id);
}

void SharedMap::MergeDuplicates(Map& map) const {
  std::vector<MapPointId> duplicates;
  for (const auto& [id, point] : map.points()) {
    if (id.local_map != own_ && Representative(map, id) != id) duplicates.push_back(id);
  }
  for (const MapPointId& id : duplicates) {
    if (!map.ReplacePoint(id, Representative(map, id))) map.RemovePoint(id);
  }
}

PlacementChange SharedMap::Place(Map& map) {
  PlacementChange change;
  RemoveGone(map, change);
  std::set<LocalMapId> waiting;
  for (auto& [source, placing] : placings_) {
    if (source != own_ && !PlaceSource(source, map, change)) waiting.insert(source);
  }
  MergeDuplicates(map);
  for (const auto& [source, placing] : placings_) {
    if (source != own_ && placing.changed) PlaceObservations(source, map);
  }
  for (auto& [source, placing] : placings_) placing.changed = waiting.contains(source);
  return change;
}

bool SharedMap::PlaceSource(LocalMapId source, Map& map, PlacementChange& change) {
  Placing& placing = placings_[source];
  KeyframeId anchor = MostCovisible(map, source);
  if (!anchor.IsValid()) anchor = Nearest(map, source);
  if (!anchor.IsValid()) return false;
  const Rigid3d local_from_global = LocalFromGlobal(map, anchor);
  const Rigid3d motion = local_from_global * placing.local_from_global.Inverse();
  const bool moved = motion.translation.norm() > kSmallestMotion_m ||
                     RotationAngle(motion.rotation) > kSmallestTurn_rad;
  if (!moved && !placing.changed) return true;
  placing = {local_from_global, true};
  PlaceKeyframes(source, local_from_global, map, change);
  PlacePoints(source, local_from_global, map);
  return true;
}

void SharedMap::PlaceKeyframes(LocalMapId source, const Rigid3d& local_from_global, Map& map,
                               PlacementChange& change) {
  for (auto it = keyframes_.lower_bound({source, 0});
       it != keyframes_.end() && it->first.local_map == source; ++it) {
    const auto& [id, foreign] = *it;
    const Rigid3d camera_from_local =
        CameraFromLocal(foreign.camera_from_global, local_from_global);
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
    map.SetParent(id, foreign.parent);
  }
}

void SharedMap::PlacePoints(LocalMapId source, const Rigid3d& local_from_global, Map& map) {
  for (auto it = points_.lower_bound({source, 0});
       it != points_.end() && it->first.local_map == source; ++it) {
    const auto& [id, shared] = *it;
    if (Representative(map, id) != id) continue;
    const Eigen::Vector3d position = local_from_global * shared.position_in_global;
    if (map.FindPoint(id) == nullptr) {
      MapPoint point;
      point.id = id;
      point.position_in_map = position;
      map.AddPoint(std::move(point));
    } else {
      map.SetPosition(id, position);
    }
    map.SetPointAppearance(id, shared.descriptor,
                           local_from_global.rotation * shared.normal_in_global,
                           shared.min_distance, shared.max_distance, shared.reference);
  }
}

void SharedMap::PlaceObservations(LocalMapId source, Map& map) {
  for (auto it = keyframes_.lower_bound({source, 0});
       it != keyframes_.end() && it->first.local_map == source; ++it) {
    const auto& [id, foreign] = *it;
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr) continue;
    for (uint32_t k = 0; k < foreign.points.size(); ++k) {
      const MapPointId wanted =
          foreign.points[k].IsValid() ? Representative(map, foreign.points[k]) : MapPointId();
      const MapPointId held = keyframe->points[k];
      if (held == wanted) continue;
      if (held.IsValid()) map.RemoveObservation(held, id);
      if (wanted.IsValid()) map.AddObservation(wanted, id, k);
    }
  }
}

}  // namespace corbslam

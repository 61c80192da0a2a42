#include "client_agent/upload/observation_mirror.h"

#include "absl/container/flat_hash_set.h"

namespace corbslam::client_agent {

void ObservationMirror::AddKeyframe(KeyframeId id, size_t keypoints) {
  points_.try_emplace(id, keypoints);
}

void ObservationMirror::Erase(KeyframeId keyframe, uint32_t keypoint) {
  MapPointId& point = points_.at(keyframe)[keypoint];
  const auto it = observers_.find(point);
  pairs_ += it->second.size();
  it->second.erase(keyframe);
  if (it->second.empty()) observers_.erase(it);
  point = MapPointId();
}

void ObservationMirror::RemoveKeyframe(KeyframeId id) {
  const auto it = points_.find(id);
  if (it == points_.end()) return;
  for (uint32_t k = 0; k < it->second.size(); ++k) {
    if (it->second[k].IsValid()) Erase(id, k);
  }
  points_.erase(it);
}

void ObservationMirror::RemovePoint(MapPointId id) {
  const auto it = observers_.find(id);
  if (it == observers_.end()) return;
  for (const auto& [keyframe, keypoint] : it->second) points_.at(keyframe)[keypoint] = MapPointId();
  pairs_ += it->second.size() * it->second.size() / 2;
  observers_.erase(it);
}

void ObservationMirror::ReplacePoint(MapPointId replaced, MapPointId survivor) {
  const auto it = observers_.find(replaced);
  if (it == observers_.end()) return;
  const std::map<KeyframeId, uint32_t> moved = std::move(it->second);
  observers_.erase(it);
  auto& to = observers_[survivor];
  pairs_ += moved.size() * (moved.size() + to.size());
  for (const auto& [keyframe, keypoint] : moved) {
    const bool handed_over = to.emplace(keyframe, keypoint).second;
    points_.at(keyframe)[keypoint] = handed_over ? survivor : MapPointId();
  }
}

bool ObservationMirror::Apply(const ObservationChange& change) {
  const auto seen = points_.find(change.keyframe);
  if (seen == points_.end() || change.keypoint >= seen->second.size()) return false;
  const auto observers = observers_.find(change.point);
  if (observers != observers_.end()) {
    if (const auto at = observers->second.find(change.keyframe); at != observers->second.end()) {
      Erase(change.keyframe, at->second);
    }
  }
  if (change.kind == ObservationChange::Kind::kRemoved) return true;
  if (seen->second[change.keypoint].IsValid()) Erase(change.keyframe, change.keypoint);
  seen->second[change.keypoint] = change.point;
  auto& to = observers_[change.point];
  pairs_ += to.size();
  to.emplace(change.keyframe, change.keypoint);
  return true;
}

std::map<KeyframeId, uint32_t> ObservationMirror::Observations(MapPointId id) const {
  const auto it = observers_.find(id);
  return it == observers_.end() ? std::map<KeyframeId, uint32_t>() : it->second;
}

bool ObservationMirror::AppendChanges(const Keyframe& keyframe, const Rules& rules,
                                      std::vector<ObservationChange>& changes) {
  const KeyframeId id = keyframe.id();
  std::vector<MapPointId>& told = points_.at(id);
  // The points that the keyframe sees are gathered once they are asked for.
  absl::flat_hash_set<MapPointId> seen;
  const auto sees = [&](MapPointId point) {
    if (seen.empty()) seen.insert(keyframe.points.begin(), keyframe.points.end());
    return seen.contains(point);
  };
  for (uint32_t k = 0; k < told.size(); ++k) {
    const MapPointId now = keyframe.points[k];
    if (!told[k].IsValid() || told[k] == now) continue;
    if (!now.IsValid() && told[k].local_map != id.local_map && !rules.is_withdrawn(k) &&
        !sees(told[k])) {
      continue;
    }
    if (!rules.has_room()) return false;
    changes.push_back({ObservationChange::Kind::kRemoved, told[k], id, k});
    Erase(id, k);
  }
  bool complete = true;
  for (uint32_t k = 0; k < told.size(); ++k) {
    const MapPointId now = keyframe.points[k];
    if (!now.IsValid() || told[k].IsValid() || !rules.is_sent(k)) continue;
    if (!rules.can_tell(now)) {
      complete = false;
      continue;
    }
    if (!rules.has_room()) return false;
    changes.push_back({ObservationChange::Kind::kAdded, now, id, k});
    told[k] = now;
    auto& observers = observers_[now];
    pairs_ += observers.size();
    observers.emplace(id, k);
  }
  return complete;
}

}  // namespace corbslam::client_agent

#include "map_store/sharing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "map_store/island_view.h"
#include "map_store/placement.h"

namespace corbslam::map_store {
namespace {

// About what an item takes on the wire.
constexpr size_t kLightBytes = 72;
constexpr size_t kPointBytes = 120;
constexpr size_t kObservationBytes = 32;
constexpr size_t kIdBytes = 12;
constexpr size_t kBytesPerKeypoint = 64;

// Less is not worth a message.
constexpr double kMinRotation_rad = 1e-6;
constexpr double kMinTranslation = 1e-5;

bool HasMoved(const Similarity3d& a, const Similarity3d& b) {
  return std::abs(a.scale - b.scale) > kMinRotation_rad ||
         RotationAngle(a.rotation.conjugate() * b.rotation) > kMinRotation_rad ||
         (a.translation - b.translation).norm() > kMinTranslation;
}

class Budget {
 public:
  explicit Budget(size_t bytes) : left_(bytes) {}
  // False, and the update is not complete, when it does not fit; the first item always does.
  bool Take(size_t bytes) {
    if (bytes > left_ && !first_) {
      complete_ = false;
      left_ = 0;
      return false;
    }
    first_ = false;
    left_ -= std::min(left_, bytes);
    return true;
  }
  bool complete() const { return complete_; }

 private:
  size_t left_;
  bool first_ = true;
  bool complete_ = true;
};

struct ForeignKeyframe {
  const LocalMapState* local_map = nullptr;
  const Keyframe* keyframe = nullptr;
  Similarity3d camera_from_global;
  // Keypoint and landmark.
  std::vector<std::pair<uint32_t, MapPointId>> points;
  int shared_landmarks = 0;
  double distance = 0;
};

// Compares what an agent has been sent with what is there now.
class ShareStep {
 public:
  ShareStep(const MissionState& state, const Island& island, const MapStoreOptions& options,
            size_t byte_budget, ShareState& share)
      : state_(state), island_(island), options_(options), budget_(byte_budget), share_(share) {
    for (const LocalMapId& id : island.local_maps) {
      poses_[id] = ComputePoses(*state.FindLocalMap(id), state.global);
    }
  }

  SharedUpdate Take() {
    update_.revision = state_.global.revision;
    update_.restart = std::exchange(share_.restart, false);
    CollectForeign();
    TakeRemovals();
    TakeOwnKeyframes();
    TakeLandmarks();
    TakeMoves();
    TakeObservations();
    TakeFullKeyframes();
    if (budget_.complete()) share_.complete_at_version = island_.shared_version;
    return std::move(update_);
  }

 private:
  static std::vector<std::pair<uint32_t, MapPointId>> Compact(
      const std::vector<MapPointId>& points) {
    std::vector<std::pair<uint32_t, MapPointId>> compact;
    for (uint32_t keypoint = 0; keypoint < points.size(); ++keypoint) {
      if (points[keypoint].IsValid()) compact.emplace_back(keypoint, points[keypoint]);
    }
    return compact;
  }

  bool IsOwn(MapPointId point) const { return point.local_map == share_.local_map; }
  bool IsKnown(MapPointId point) const { return IsOwn(point) || share_.points.contains(point); }

  void CollectForeign() {
    absl::flat_hash_set<MapPointId> own_landmarks;
    std::vector<Eigen::Vector3d> own_centres;
    const LocalMapState& own = *state_.FindLocalMap(share_.local_map);
    for (const auto& [id, keyframe] : own.map.keyframes()) {
      own_centres.push_back(CameraCentre(poses_.at(own.id).at(id).ToRigid()));
      for (const MapPointId& point : ObservedPoints(state_, own, keyframe)) {
        if (point.IsValid()) own_landmarks.insert(point);
      }
    }
    for (const LocalMapId& local_map_id : island_.local_maps) {
      if (local_map_id == own.id) continue;
      const LocalMapState& local_map = *state_.FindLocalMap(local_map_id);
      for (const auto& [id, keyframe] : local_map.map.keyframes()) {
        if (!local_map.IsSettled(id)) continue;
        ForeignKeyframe& foreign = foreign_[id];
        foreign.local_map = &local_map;
        foreign.keyframe = &keyframe;
        foreign.camera_from_global = poses_.at(local_map_id).at(id);
        foreign.points = Compact(ObservedPoints(state_, local_map, keyframe));
        MeasureNearness(own_landmarks, own_centres, foreign);
      }
    }
  }

  static void MeasureNearness(const absl::flat_hash_set<MapPointId>& own_landmarks,
                              const std::vector<Eigen::Vector3d>& own_centres,
                              ForeignKeyframe& foreign) {
    for (const auto& [keypoint, point] : foreign.points) {
      if (own_landmarks.contains(point)) ++foreign.shared_landmarks;
    }
    const Eigen::Vector3d centre = CameraCentre(foreign.camera_from_global.ToRigid());
    foreign.distance = std::numeric_limits<double>::max();
    for (const Eigen::Vector3d& own : own_centres) {
      foreign.distance = std::min(foreign.distance, (own - centre).squaredNorm());
    }
  }

  void TakeRemovals() {
    for (auto it = share_.keyframes.begin(); it != share_.keyframes.end();) {
      if (foreign_.contains(it->first) || !budget_.Take(kIdBytes)) {
        ++it;
        continue;
      }
      update_.removed_keyframes.push_back(it->first);
      it = share_.keyframes.erase(it);
    }
    // Apart from the walk: what replaces a point may take others off the list.
    std::vector<MapPointId> gone;
    for (const auto& [id, position] : share_.points) {
      if (state_.FindPoint(id) == nullptr && budget_.Take(kIdBytes)) gone.push_back(id);
    }
    for (const MapPointId& id : gone) share_.points.erase(id);
    for (const MapPointId& id : gone) TakeReplacement(id);
  }

  // A point whose owner replaced it goes on as the point that stands for it now.
  void TakeReplacement(MapPointId gone) {
    const MapPointId survivor = ResolvePoint(state_, gone);
    if (!survivor.IsValid() || !poses_.contains(survivor.local_map)) {
      update_.removed_points.push_back(gone);
      return;
    }
    TakePoint(survivor);
    update_.landmarks.push_back({survivor, {gone}});
  }

  void TakeOwnKeyframes() {
    const LocalMapState& own = *state_.FindLocalMap(share_.local_map);
    for (const auto& [id, pose] : poses_.at(own.id)) {
      if (!state_.global.keyframes.contains(id)) continue;
      const auto sent = share_.own_keyframes.find(id);
      if (sent != share_.own_keyframes.end() && !HasMoved(sent->second, pose)) continue;
      if (!budget_.Take(kLightBytes)) return;
      update_.own_keyframes.push_back({id, pose});
      share_.own_keyframes[id] = pose;
    }
  }

  // Sets of which the agent holds a point, or is about to.
  void TakeLandmarks() {
    for (const auto& [survivor, members] : state_.global.landmarks.sets()) {
      const bool known =
          IsKnown(survivor) || std::any_of(members.begin(), members.end(),
                                           [this](MapPointId point) { return IsKnown(point); });
      if (known) TakeLandmark(survivor, members);
    }
  }

  void TakeLandmark(MapPointId survivor, const std::set<MapPointId>& members) {
    if (state_.FindPoint(survivor) == nullptr) return;
    std::vector<MapPointId> listed(members.begin(), members.end());
    const auto sent = share_.landmarks.find(survivor);
    if (sent != share_.landmarks.end() && sent->second == listed) return;
    if (!budget_.Take(kIdBytes * (1 + listed.size()))) return;
    TakePoint(survivor);
    update_.landmarks.push_back({survivor, listed});
    // Members are held no more: the survivor stands for them.
    for (const MapPointId& member : listed) share_.points.erase(member);
    share_.landmarks[survivor] = std::move(listed);
  }

  void TakeMoves() {
    for (auto& [id, sent] : share_.keyframes) {
      const auto it = foreign_.find(id);
      if (it == foreign_.end()) continue;
      if (!HasMoved(sent.camera_from_global, it->second.camera_from_global)) continue;
      if (!budget_.Take(kLightBytes)) return;
      update_.moved_keyframes.push_back({id, it->second.camera_from_global});
      sent.camera_from_global = it->second.camera_from_global;
    }
    for (auto& [id, sent] : share_.points) {
      if (state_.FindPoint(id) == nullptr) continue;
      const Eigen::Vector3d position = PositionOf(id);
      if ((position - sent).norm() <= kMinTranslation) continue;
      if (!budget_.Take(kLightBytes)) return;
      update_.moved_points.push_back({id, position});
      sent = position;
    }
  }

  void TakeObservations() {
    for (auto& [id, sent] : share_.keyframes) {
      const auto it = foreign_.find(id);
      if (it == foreign_.end() || it->second.points == sent.points) continue;
      if (!budget_.Take(kObservationBytes)) return;
      TakeObservationChanges(id, sent.points, it->second.points);
      sent.points = it->second.points;
    }
  }

  void TakeObservationChanges(KeyframeId id,
                              const std::vector<std::pair<uint32_t, MapPointId>>& before,
                              const std::vector<std::pair<uint32_t, MapPointId>>& now) {
    for (const auto& [keypoint, point] : before) {
      if (std::binary_search(now.begin(), now.end(), std::make_pair(keypoint, point))) continue;
      budget_.Take(kObservationBytes);
      update_.observations.push_back({ObservationChange::Kind::kRemoved, point, id, keypoint});
    }
    for (const auto& [keypoint, point] : now) {
      if (std::binary_search(before.begin(), before.end(), std::make_pair(keypoint, point))) {
        continue;
      }
      budget_.Take(kObservationBytes);
      TakePoint(point);
      update_.observations.push_back({ObservationChange::Kind::kAdded, point, id, keypoint});
    }
  }

  std::vector<KeyframeId> NearestFirst() const {
    std::vector<KeyframeId> nearest;
    for (const auto& [id, foreign] : foreign_) nearest.push_back(id);
    std::sort(nearest.begin(), nearest.end(), [this](KeyframeId a, KeyframeId b) {
      const ForeignKeyframe& first = foreign_.at(a);
      const ForeignKeyframe& second = foreign_.at(b);
      return std::make_tuple(-first.shared_landmarks, first.distance, a) <
             std::make_tuple(-second.shared_landmarks, second.distance, b);
    });
    return nearest;
  }

  void TakeFullKeyframes() {
    for (const KeyframeId& id : NearestFirst()) {
      if (share_.keyframes.contains(id)) continue;
      if (share_.keyframes.size() >= options_.max_shared_keyframes) return;
      const ForeignKeyframe& foreign = foreign_.at(id);
      const size_t keypoints = foreign.keyframe->keypoints().size();
      if (!budget_.Take(kLightBytes + keypoints * kBytesPerKeypoint)) return;
      SharedKeyframe shared;
      shared.payload = foreign.keyframe->payload;
      shared.camera_from_global = foreign.camera_from_global;
      shared.parent = foreign.keyframe->parent;
      shared.points.resize(keypoints);
      for (const auto& [keypoint, point] : foreign.points) {
        shared.points[keypoint] = point;
        TakePoint(point);
      }
      update_.keyframes.push_back(std::move(shared));
      share_.keyframes[id] = {foreign.camera_from_global, foreign.points};
    }
  }

  Eigen::Vector3d PositionOf(MapPointId id) const {
    const LocalMapState& owner = *state_.FindLocalMap(id.local_map);
    return ComputePosition(*owner.map.FindPoint(id), owner, state_.global, poses_.at(owner.id));
  }

  // In full, unless the agent has it; with the landmark that it stands for. Goes with what needs
  // it, whatever the budget says.
  void TakePoint(MapPointId id) {
    if (IsOwn(id) || share_.points.contains(id)) return;
    const LocalMapState& owner = *state_.FindLocalMap(id.local_map);
    const MapPoint& point = *owner.map.FindPoint(id);
    const Similarity3d global_from_local =
        IslandFromLocal(point.reference, owner, state_.global, poses_.at(owner.id));
    SharedMapPoint shared;
    shared.id = id;
    shared.position_in_global = PositionOf(id);
    shared.reference = point.reference;
    shared.descriptor = point.descriptor;
    shared.normal_in_global = global_from_local.rotation * point.normal_in_map;
    shared.min_distance = point.min_distance * global_from_local.scale;
    shared.max_distance = point.max_distance * global_from_local.scale;
    budget_.Take(kPointBytes);
    share_.points[id] = shared.position_in_global;
    update_.points.push_back(std::move(shared));
    const auto& sets = state_.global.landmarks.sets();
    if (const auto it = sets.find(id); it != sets.end()) TakeLandmark(id, it->second);
  }

  const MissionState& state_;
  const Island& island_;
  const MapStoreOptions& options_;
  Budget budget_;
  ShareState& share_;
  std::map<LocalMapId, IslandPoses> poses_;
  std::map<KeyframeId, ForeignKeyframe> foreign_;
  SharedUpdate update_;
};

bool HasSent(const ShareState& share) {
  return !share.keyframes.empty() || !share.points.empty() || !share.landmarks.empty() ||
         !share.own_keyframes.empty();
}

// Forgets what was sent; the agent is told to forget it too if it has anything.
void StartAgain(LocalMapId local_map, IslandId island, ShareState& share) {
  const bool had_any = share.restart || HasSent(share);
  share = ShareState();
  share.local_map = local_map;
  share.island = island;
  share.restart = had_any;
}

void NoteSent(uint64_t revision, ShareState& share) {
  share.updates_of_last_revision =
      share.last_revision == revision ? share.updates_of_last_revision + 1 : 1;
  share.last_revision = revision;
}

}  // namespace

std::optional<SharedUpdate> TakeSharedUpdate(const MissionState& state,
                                             const MapStoreOptions& options, size_t byte_budget,
                                             AgentState& agent) {
  if (agent.local_maps.empty()) return std::nullopt;
  ShareState& share = agent.share;
  const LocalMapId own = agent.local_maps.back();
  const Island& island = *state.FindIslandOf(own);
  if (share.local_map != own || share.island != island.id) StartAgain(own, island.id, share);
  if (island.local_maps.size() < 2) {
    // It may have been larger, under the same name.
    if (HasSent(share)) StartAgain(own, island.id, share);
    if (!std::exchange(share.restart, false)) return std::nullopt;
    SharedUpdate forget;
    forget.revision = state.global.revision;
    forget.restart = true;
    NoteSent(forget.revision, share);
    return forget;
  }
  if (share.complete_at_version == island.shared_version && !share.restart) return std::nullopt;
  SharedUpdate update = ShareStep(state, island, options, byte_budget, share).Take();
  if (update.IsEmpty()) return std::nullopt;
  NoteSent(update.revision, share);
  return update;
}

void ResumeSharing(uint64_t last_revision, ShareState& share) {
  const bool certain = last_revision != 0 && last_revision == share.last_revision &&
                       share.updates_of_last_revision == 1;
  if (certain) return;
  const bool holds_any = last_revision != 0;
  share = ShareState();
  share.restart = holds_any;
}

}  // namespace corbslam::map_store

#include "map_store/share_step.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "map_store/island_view.h"
#include "map_store/placement.h"
#include "map_store/share_scope.h"

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
// Of a point, as a share of the least distance from which it is seen: less than a tenth of a pixel.
constexpr double kMinPointMotion = 2e-4;

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
      : state_(state),
        island_(island),
        options_(options),
        budget_(byte_budget),
        share_(share),
        scope_(FindShareScope(state, island, share)) {}

  SharedUpdate Take() {
    update_.revision = state_.global.revision;
    update_.restart = std::exchange(share_.restart, false);
    CollectForeign();
    TakeRemovals();
    if (scope_.everything || scope_.places) TakeOwnKeyframes();
    TakeLandmarks();
    TakeKeyframeMoves();
    TakePointMoves();
    TakeObservations();
    TakeFullKeyframes();
    if (budget_.complete()) NoteComplete();
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

  void NoteComplete() {
    share_.complete_at_version = island_.shared_version;
    share_.seen_version = state_.version;
    share_.seen_revision = state_.global.revision;
    share_.seen_local_maps = {island_.local_maps.begin(), island_.local_maps.end()};
  }

  const IslandPoses& PosesOf(const LocalMapState& local_map) const {
    const auto [it, added] = poses_.try_emplace(local_map.id);
    if (added) it->second = ComputePoses(local_map, state_.global);
    return it->second;
  }

  bool IsHere(LocalMapId id) const {
    const auto it = state_.global.island_of.find(id);
    return it != state_.global.island_of.end() && it->second == island_.id;
  }

  bool IsShareable(const LocalMapState& local_map, KeyframeId id) const {
    return local_map.IsFollowedBy(options_.share_after, id);
  }

  void AddForeign(const LocalMapState& local_map, const Keyframe& keyframe) {
    ForeignKeyframe& foreign = foreign_[keyframe.id()];
    foreign.keyframe = &keyframe;
    foreign.camera_from_global = PosesOf(local_map).at(keyframe.id());
    foreign.points = Compact(ObservedPoints(state_, local_map, keyframe));
  }

  // Others' keyframes within the scope.
  void CollectForeign() {
    for (const LocalMapId& id : island_.local_maps) {
      if (id == share_.local_map || !scope_.everything) continue;
      const LocalMapState& local_map = *state_.FindLocalMap(id);
      for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
        if (IsShareable(local_map, keyframe_id)) AddForeign(local_map, keyframe);
      }
    }
    for (const KeyframeId& id : scope_.keyframes) {
      if (id.local_map == share_.local_map) continue;
      const LocalMapState& local_map = *state_.FindLocalMap(id.local_map);
      const Keyframe* keyframe = local_map.map.FindKeyframe(id);
      if (keyframe != nullptr && IsShareable(local_map, id)) AddForeign(local_map, *keyframe);
    }
  }

  void MeasureNearness(const std::vector<KeyframeId>& ids) {
    absl::flat_hash_set<MapPointId> own_landmarks;
    std::vector<Eigen::Vector3d> own_centres;
    const LocalMapState& own = *state_.FindLocalMap(share_.local_map);
    for (const auto& [id, keyframe] : own.map.keyframes()) {
      own_centres.push_back(CameraCentre(PosesOf(own).at(id).ToRigid()));
      for (const MapPointId& point : ObservedPoints(state_, own, keyframe)) {
        if (point.IsValid()) own_landmarks.insert(point);
      }
    }
    for (const KeyframeId& id : ids) MeasureNearness(own_landmarks, own_centres, foreign_.at(id));
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

  // Ids of what the agent was sent, within the scope.
  template <typename Id, typename Sent>
  std::vector<Id> SentInScope(const Sent& sent, const std::vector<Id>& changed) const {
    std::vector<Id> ids;
    if (scope_.everything) {
      for (const auto& [id, item] : sent) ids.push_back(id);
    } else {
      std::copy_if(changed.begin(), changed.end(), std::back_inserter(ids),
                   [&sent](Id id) { return sent.contains(id); });
    }
    return ids;
  }

  void TakeRemovals() {
    for (const KeyframeId& id : SentInScope(share_.keyframes, scope_.keyframes)) {
      if (foreign_.contains(id) || !budget_.Take(kIdBytes)) continue;
      update_.removed_keyframes.push_back(id);
      share_.keyframes.erase(id);
    }
    // Apart from the walk: what replaces a point may take others off the list.
    std::vector<MapPointId> gone;
    for (const MapPointId& id : SentInScope(share_.points, scope_.points)) {
      if (state_.FindPoint(id) == nullptr && budget_.Take(kIdBytes)) gone.push_back(id);
    }
    for (const MapPointId& id : gone) share_.points.erase(id);
    for (const MapPointId& id : gone) TakeReplacement(id);
  }

  // A point whose owner replaced it goes on as the point that stands for it now.
  void TakeReplacement(MapPointId gone) {
    const MapPointId survivor = ResolvePoint(state_, gone);
    if (!survivor.IsValid() || !IsHere(survivor.local_map)) {
      update_.removed_points.push_back(gone);
      return;
    }
    TakePoint(survivor);
    update_.landmarks.push_back({survivor, {gone}});
  }

  void TakeOwnKeyframes() {
    const LocalMapState& own = *state_.FindLocalMap(share_.local_map);
    for (const auto& [id, pose] : PosesOf(own)) {
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
    const Landmarks::Sets& sets = state_.global.landmarks.sets();
    if (scope_.everything) {
      for (const auto& [survivor, members] : sets) TakeKnownLandmark(survivor, members);
      return;
    }
    std::set<MapPointId> survivors;
    for (const MapPointId& id : scope_.points) survivors.insert(ResolvePoint(state_, id));
    for (const MapPointId& survivor : survivors) {
      const auto it = sets.find(survivor);
      if (it != sets.end()) TakeKnownLandmark(survivor, it->second);
    }
  }

  void TakeKnownLandmark(MapPointId survivor, const std::set<MapPointId>& members) {
    const bool known =
        IsKnown(survivor) || std::any_of(members.begin(), members.end(),
                                         [this](MapPointId point) { return IsKnown(point); });
    if (known) TakeLandmark(survivor, members);
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

  // Also those that nobody touched: they follow others of their local map.
  void TakeKeyframeMoves() {
    for (auto& [id, sent] : share_.keyframes) {
      const bool in_scope =
          scope_.everything || scope_.places || scope_.local_maps.contains(id.local_map);
      if (!in_scope || state_.FindKeyframe(id) == nullptr) continue;
      const Similarity3d& pose = PosesOf(*state_.FindLocalMap(id.local_map)).at(id);
      if (!HasMoved(sent.camera_from_global, pose)) continue;
      if (!budget_.Take(kLightBytes)) return;
      update_.moved_keyframes.push_back({id, pose});
      sent.camera_from_global = pose;
    }
  }

  void TakePointMoves() {
    if (scope_.everything || scope_.places) {
      for (auto& [id, sent] : share_.points) {
        if (!TakePointMove(id, sent)) return;
      }
      return;
    }
    std::set<MapPointId> ids(scope_.points.begin(), scope_.points.end());
    for (const LocalMapId& id : scope_.local_maps) InsertFollowers(*state_.FindLocalMap(id), ids);
    for (const MapPointId& id : ids) {
      const auto it = share_.points.find(id);
      if (it != share_.points.end() && !TakePointMove(id, it->second)) return;
    }
  }

  // Points that keyframes see which fusion has not placed: they move with these.
  void InsertFollowers(const LocalMapState& local_map, std::set<MapPointId>& points) const {
    for (const auto& [id, keyframe] : local_map.map.keyframes()) {
      if (state_.global.keyframes.contains(id)) continue;
      for (const MapPointId& point : keyframe.points) {
        if (point.IsValid()) points.insert(point);
      }
    }
  }

  // False when the budget ends.
  bool TakePointMove(MapPointId id, Eigen::Vector3d& sent) {
    const MapPoint* point = state_.FindPoint(id);
    if (point == nullptr) return true;
    const Eigen::Vector3d position = PositionOf(id);
    const double worth_telling = std::max(kMinTranslation, kMinPointMotion * point->min_distance);
    if ((position - sent).norm() <= worth_telling) return true;
    if (!budget_.Take(kLightBytes)) return false;
    update_.moved_points.push_back({id, position});
    sent = position;
    return true;
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

  // Those that the agent does not have. Where few are news, the order is theirs.
  std::vector<KeyframeId> NewOnesNearestFirst() {
    std::vector<KeyframeId> nearest;
    for (const auto& [id, foreign] : foreign_) {
      if (!share_.keyframes.contains(id)) nearest.push_back(id);
    }
    if (!scope_.everything) return nearest;
    MeasureNearness(nearest);
    std::sort(nearest.begin(), nearest.end(), [this](KeyframeId a, KeyframeId b) {
      const ForeignKeyframe& first = foreign_.at(a);
      const ForeignKeyframe& second = foreign_.at(b);
      return std::make_tuple(-first.shared_landmarks, first.distance, a) <
             std::make_tuple(-second.shared_landmarks, second.distance, b);
    });
    return nearest;
  }

  void TakeFullKeyframes() {
    for (const KeyframeId& id : NewOnesNearestFirst()) {
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
    return ComputePosition(*owner.map.FindPoint(id), owner, state_.global, PosesOf(owner));
  }

  // In full, unless the agent has it; with the landmark that it stands for. Goes with what needs
  // it, whatever the budget says.
  void TakePoint(MapPointId id) {
    if (IsOwn(id) || share_.points.contains(id)) return;
    const LocalMapState& owner = *state_.FindLocalMap(id.local_map);
    const MapPoint& point = *owner.map.FindPoint(id);
    const Similarity3d global_from_local =
        IslandFromLocal(point.reference, owner, state_.global, PosesOf(owner));
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
  const ShareScope scope_;
  mutable std::map<LocalMapId, IslandPoses> poses_;
  std::map<KeyframeId, ForeignKeyframe> foreign_;
  SharedUpdate update_;
};

}  // namespace

SharedUpdate TakeShareStep(const MissionState& state, const Island& island,
                           const MapStoreOptions& options, size_t byte_budget, ShareState& share) {
  return ShareStep(state, island, options, byte_budget, share).Take();
}

}  // namespace corbslam::map_store

#include "map_store/sharing/share_step.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "map_store/sharing/share_news.h"
#include "map_store/sharing/share_order.h"
#include "map_store/sharing/share_reach.h"
#include "map_store/view/placement.h"
#include "map_store/view/sights.h"

namespace corbslam::map_store {
namespace {

// What items take on the wire, about.
constexpr size_t kLightBytes = 72;
constexpr size_t kOwnPoseBytes = 136;
constexpr size_t kPointBytes = 120;
constexpr size_t kObservationBytes = 32;
constexpr size_t kIdBytes = 12;
constexpr size_t kBytesPerKeypoint = 64;

// Smaller motions are not worth a message.
constexpr double kMinRotation_rad = 1e-6;
constexpr double kMinTranslation = 1e-5;
// Least motion of a point, as a share of the least distance from which it is expected to be found:
// half a pixel there at 700 px focal length, as agents tell it
// (client_agent/upload/update_recorder.h).
constexpr double kMinPointMotion = 7e-4;

bool HasMoved(const Similarity3d& a, const Similarity3d& b) {
  return std::abs(a.scale - b.scale) > kMinRotation_rad ||
         RotationAngle(a.rotation.conjugate() * b.rotation) > kMinRotation_rad ||
         (a.translation - b.translation).norm() > kMinTranslation;
}

bool HasMoved(const OwnKeyframePose& a, const OwnKeyframePose& b) {
  return HasMoved(a.camera_from_global, b.camera_from_global) ||
         HasMoved(Similarity3d::FromRigid(a.camera_from_local),
                  Similarity3d::FromRigid(b.camera_from_local));
}

class Budget {
 public:
  explicit Budget(size_t bytes) : left_(bytes) {}
  // Returns false, and the update is not complete, if the item does not fit; the first item always
  // does.
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
  // Lets nothing more be taken, though something is left.
  void End() {
    complete_ = false;
    first_ = false;
    left_ = 0;
  }

 private:
  size_t left_;
  bool first_ = true;
  bool complete_ = true;
};

// The steps of a piece, after which writers have their turn: 2 to 4 ms.
constexpr size_t kStepsInAPiece = 4000;
constexpr size_t kStepsOfSights = 25;
constexpr size_t kStepsOfNewKeyframe = 200;

// Goes through what may be news, compares it with what was sent, and sends what is new.
class ShareStep {
 public:
  ShareStep(const MissionState& state, const Island& island, const MapStoreOptions& options,
            size_t byte_budget, ShareState& share, LongRead& read)
      : state_(state),
        island_(island.id),
        shared_version_(island.shared_version),
        options_(options),
        budget_(byte_budget),
        share_(share),
        news_(share.news),
        steps_(read, kStepsInAPiece),
        poses_(state, all_placed_),
        anchors_(state.global),
        reach_(state, poses_, share) {}

  SharedUpdate Take() {
    update_.revision = state_.global.revision;
    update_.restart = std::exchange(share_.restart, false);
    const Island& island = state_.global.islands.at(island_);
    for (const LocalMapId& id : CollectNews(state_, island, share_)) {
      if (id != share_.local_map) FindFollowers(*state_.FindLocalMap(id));
    }
    if (news_.own_keyframes && share_.local_map.IsValid()) TakeOwnKeyframes();
    TakeKeyframes();
    TakePointMoves();
    update_.more_places = !budget_.complete();
    TakeLandmarks();
    TakeSights();
    TakeNewKeyframes();
    share_.unfinished = !budget_.complete();
    if (budget_.complete()) share_.complete_at_version = shared_version_;
    return std::move(update_);
  }

 private:
  // The caller calls this between two items. Returns false if what comes next is another update's.
  bool GoesOn(size_t steps) {
    if (!budget_.complete()) return false;
    const uint64_t version = state_.version;
    // Places of two revisions in one update would not fit together.
    if (!steps_.Advance(steps).ok() || state_.global.revision != update_.revision) {
      budget_.End();
      return false;
    }
    if (state_.version != version) ForgetPlaces();
    return true;
  }

  // Owners have moved keyframes in a pause.
  void ForgetPlaces() {
    poses_.Clear();
    anchors_.Clear();
  }

  bool IsOwn(MapPointId point) const { return point.local_map == share_.local_map; }
  // Returns whether the agent is to hear which landmark the point belongs to. Of its own points it
  // hears that only where it wants everything, or holds another's point of that landmark.
  bool IsKnown(MapPointId point) const {
    return (IsOwn(point) && share_.scope.mode == ShareMode::kEverything) ||
           share_.points.contains(point);
  }

  const IslandPoses& PosesOf(const LocalMapState& local_map) { return poses_.Of(local_map); }

  bool IsHere(LocalMapId id) const {
    const auto it = state_.global.island_of.find(id);
    return it != state_.global.island_of.end() && it->second == island_;
  }

  Similarity3d GlobalFromLocal(KeyframeId reference, const LocalMapState& local_map) {
    return IslandFromLocal(reference, local_map, state_.global, PosesOf(local_map));
  }

  // Notes news of keyframes that fusion has not placed, which follow others of their local map, and
  // of the points that follow them.
  void FindFollowers(const LocalMapState& local_map) {
    for (const LocalMapId& name : local_map.Names()) FindFollowers(name, local_map);
  }
  void FindFollowers(LocalMapId name, const LocalMapState& local_map) {
    for (auto it = share_.keyframes.lower_bound(KeyframeId{name, 0});
         it != share_.keyframes.end() && it->first.local_map == name; ++it) {
      const Keyframe* keyframe = local_map.map.FindKeyframe(it->first);
      if (keyframe == nullptr || state_.global.keyframes.contains(it->first)) continue;
      const Similarity3d global_from_local = GlobalFromLocal(it->first, local_map);
      if (!HasMoved(it->second.global_from_local, global_from_local)) continue;
      it->second.global_from_local = global_from_local;
      news_.keyframes.insert(it->first);
      for (const MapPointId& point : keyframe->points) {
        if (share_.points.contains(point)) news_.points.insert(point);
      }
    }
  }

  void TakeOwnKeyframes() {
    const LocalMapState& own = *state_.FindLocalMap(share_.local_map);
    for (const auto& [id, camera_from_global] : PosesOf(own)) {
      const auto placed = state_.global.keyframes.find(id);
      if (placed == state_.global.keyframes.end()) continue;
      const OwnKeyframePose pose = {id, camera_from_global, placed->second.camera_from_local};
      const auto sent = share_.own_keyframes.find(id);
      if (sent != share_.own_keyframes.end() && !HasMoved(sent->second, pose)) continue;
      if (!budget_.Take(kOwnPoseBytes)) return;
      update_.own_keyframes.push_back(pose);
      share_.own_keyframes[id] = pose;
    }
    news_.own_keyframes = false;
  }

  bool IsShared(KeyframeId id) const {
    return state_.FindLocalMap(id.local_map)->IsFollowedBy(options_.share_after, id) &&
           !state_.global.culled.contains(id);
  }

  // Takes keyframes that went and those that moved; sets the new ones aside.
  void TakeKeyframes() {
    reach_.MoveWithRobot();
    for (auto it = news_.keyframes.begin(); it != news_.keyframes.end();) {
      if (!GoesOn(2)) return;
      const LocalMapState& local_map = *state_.FindLocalMap(it->local_map);
      const Keyframe* keyframe = local_map.map.FindKeyframe(*it);
      const auto sent = share_.keyframes.find(*it);
      if (sent == share_.keyframes.end()) {
        // A keyframe that is not old enough becomes news again when it is.
        const bool is_living = keyframe != nullptr && IsShared(*it);
        if (!is_living) share_.far.Erase(*it);
        const bool is_new = is_living && reach_.Wants(*it);
        if (is_new) new_keyframes_.insert(*it);
        it = is_new ? std::next(it) : news_.keyframes.erase(it);
        continue;
      }
      const bool is_there = keyframe != nullptr && IsShared(*it);
      const bool taken = is_there ? TakeMove(local_map, *sent) : TakeRemoval(sent);
      if (!taken) return;
      it = news_.keyframes.erase(it);
    }
  }

  // These return false when the budget ends.
  bool TakeRemoval(std::map<KeyframeId, SentKeyframe>::iterator sent) {
    if (!budget_.Take(kIdBytes)) return false;
    update_.removed_keyframes.push_back(sent->first);
    share_.keyframes.erase(sent);
    return true;
  }
  bool TakeMove(const LocalMapState& local_map, std::pair<const KeyframeId, SentKeyframe>& sent) {
    const Similarity3d& pose = PosesOf(local_map).at(sent.first);
    if (!HasMoved(sent.second.camera_from_global, pose)) return true;
    if (!budget_.Take(kLightBytes)) return false;
    update_.moved_keyframes.push_back({sent.first, pose});
    sent.second.camera_from_global = pose;
    return true;
  }

  // Takes points that went, and landmarks of which the agent holds a point.
  void TakeLandmarks() {
    for (auto it = news_.landmarks.begin(); it != news_.landmarks.end();) {
      if (!GoesOn(1) || !TakeLandmarkOf(*it)) return;
      it = news_.landmarks.erase(it);
    }
  }

  bool TakeLandmarkOf(MapPointId id) {
    const bool is_gone = share_.points.contains(id) && state_.FindPoint(id) == nullptr;
    if (is_gone) {
      if (!budget_.Take(kIdBytes)) return false;
      share_.points.erase(id);
      TakeReplacement(id);
    }
    const Landmarks::Sets& sets = state_.global.landmarks.sets();
    const auto set = sets.find(ResolvePoint(state_, id));
    if (set == sets.end()) return true;
    const auto& [survivor, members] = *set;
    const bool known = IsKnown(survivor) || std::ranges::any_of(members, [this](MapPointId point) {
                         return IsKnown(point);
                       });
    if (!known) return true;
    if (!budget_.Take(kIdBytes * (1 + members.size()))) return false;
    TakeLandmark(survivor, members);
    return true;
  }

  // Lets a point whose owner replaced it go on as the point that stands for it now.
  void TakeReplacement(MapPointId gone) {
    const MapPointId survivor = ResolvePoint(state_, gone);
    if (!survivor.IsValid() || !IsHere(survivor.local_map)) {
      update_.removed_points.push_back(gone);
      return;
    }
    TakePoint(survivor);
    update_.landmarks.push_back({survivor, {gone}});
    // The robot takes that as the whole landmark: its other points follow.
    share_.landmarks.erase(survivor);
  }

  // Takes the landmark with the item that needs it, whatever the budget says.
  void TakeLandmark(MapPointId survivor, const std::set<MapPointId>& members) {
    if (state_.FindPoint(survivor) == nullptr) return;
    std::vector<MapPointId> listed(members.begin(), members.end());
    const auto sent = share_.landmarks.find(survivor);
    if (sent != share_.landmarks.end() && sent->second == listed) return;
    TakePoint(survivor);
    update_.landmarks.push_back({survivor, listed});
    // The agent holds the members no more: the survivor stands for them.
    for (const MapPointId& member : listed) share_.points.erase(member);
    share_.landmarks[survivor] = std::move(listed);
  }

  void TakePointMoves() {
    if (news_.all_points_from.has_value()) {
      // These are among the points from there on.
      news_.points.erase(news_.points.lower_bound(*news_.all_points_from), news_.points.end());
    }
    for (auto it = news_.points.begin(); it != news_.points.end();) {
      if (!GoesOn(1)) return;
      const auto sent = share_.points.find(*it);
      if (sent != share_.points.end() && !TakePointMove(*it, sent->second)) return;
      it = news_.points.erase(it);
    }
    if (!news_.all_points_from.has_value()) return;
    for (auto it = share_.points.lower_bound(*news_.all_points_from); it != share_.points.end();
         ++it) {
      news_.all_points_from = it->first;
      if (!GoesOn(1) || !TakePointMove(it->first, it->second)) return;
    }
    news_.all_points_from.reset();
  }

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

  void TakeSights() {
    for (auto it = news_.sights.begin(); it != news_.sights.end();) {
      if (!GoesOn(kStepsOfSights)) return;
      const auto sent = share_.keyframes.find(*it);
      const Keyframe* keyframe = state_.FindKeyframe(*it);
      if (sent != share_.keyframes.end() && keyframe != nullptr) {
        Sights sights = SightsOf(state_, *state_.FindLocalMap(it->local_map), *keyframe);
        if (sights != *sent->second.sights) {
          if (!budget_.Take(kObservationBytes)) return;
          TakeObservationChanges(*it, *sent->second.sights, sights);
          sent->second.sights = state_.sights.Share(*it, std::move(sights));
        }
      }
      it = news_.sights.erase(it);
    }
  }

  void TakeObservationChanges(KeyframeId id, const Sights& before, const Sights& now) {
    Sights changed;
    std::ranges::set_difference(before, now, std::back_inserter(changed));
    for (const auto& [keypoint, point] : changed) {
      budget_.Take(kObservationBytes);
      update_.observations.push_back({ObservationChange::Kind::kRemoved, point, id, keypoint});
    }
    changed.clear();
    std::ranges::set_difference(now, before, std::back_inserter(changed));
    for (const auto& [keypoint, point] : changed) {
      budget_.Take(kObservationBytes);
      TakePoint(point);
      update_.observations.push_back({ObservationChange::Kind::kAdded, point, id, keypoint});
    }
  }

  void TakeNewKeyframes() {
    // After the end of the budget what the state had may be gone.
    if (new_keyframes_.empty() || !budget_.complete()) return;
    if (share_.keyframes.size() >= options_.max_shared_keyframes) return;
    if (!CountOwnLandmarks()) return;
    for (const KeyframeId& id : OrderNewKeyframes(state_, new_keyframes_, poses_, share_)) {
      if (share_.keyframes.size() >= options_.max_shared_keyframes) return;
      if (!GoesOn(kStepsOfNewKeyframe)) return;
      // The owner may have removed it meanwhile, which is news of its own.
      const Keyframe* keyframe = state_.FindKeyframe(id);
      if (keyframe == nullptr || !IsShared(id)) continue;
      if (!budget_.Take(kLightBytes + keyframe->keypoints().size() * kBytesPerKeypoint)) return;
      TakeNewKeyframe(*keyframe);
      news_.keyframes.erase(id);
    }
  }

  // Counts the agent's own landmarks in the new keyframes, unless they are counted or there are few
  // to choose from. Returns false if the update ends before that.
  bool CountOwnLandmarks() {
    OwnLandmarkCount count(state_, new_keyframes_, share_);
    while (count.Next()) {
      if (!GoesOn(kStepsOfSights)) return false;
    }
    return true;
  }

  void TakeNewKeyframe(const Keyframe& keyframe) {
    const KeyframeId id = keyframe.id();
    const LocalMapState& local_map = *state_.FindLocalMap(id.local_map);
    SentKeyframe sent;
    sent.camera_from_global = PosesOf(local_map).at(id);
    sent.global_from_local = GlobalFromLocal(id, local_map);
    sent.sights = state_.sights.Share(id, SightsOf(state_, local_map, keyframe));
    SharedKeyframe shared;
    shared.payload = keyframe.payload;
    shared.camera_from_global = sent.camera_from_global;
    shared.parent = keyframe.parent;
    shared.points.resize(keyframe.keypoints().size());
    for (const auto& [keypoint, point] : *sent.sights) {
      shared.points[keypoint] = point;
      TakePoint(point);
    }
    update_.keyframes.push_back(std::move(shared));
    share_.keyframes[id] = std::move(sent);
  }

  Eigen::Vector3d PositionOf(MapPointId id) {
    const LocalMapState& owner = *state_.FindLocalMap(id.local_map);
    return ComputePosition(*owner.map.FindPoint(id), owner, anchors_, PosesOf(owner), all_placed_);
  }

  // Takes the point in full, unless the agent has it, with the landmark that it stands for. It goes
  // with the item that needs it, whatever the budget says.
  void TakePoint(MapPointId id) {
    if (IsOwn(id) || share_.points.contains(id)) return;
    const LocalMapState& owner = *state_.FindLocalMap(id.local_map);
    const MapPoint& point = *owner.map.FindPoint(id);
    const Similarity3d global_from_local = GlobalFromLocal(point.reference, owner);
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
  const IslandId island_;
  const uint64_t shared_version_;
  const MapStoreOptions& options_;
  Budget budget_;
  ShareState& share_;
  ShareNews& news_;
  StepsInPieces steps_;
  const Unplaced all_placed_;
  PoseCache poses_;
  AnchorCache anchors_;
  ShareReach reach_;
  std::set<KeyframeId> new_keyframes_;
  SharedUpdate update_;
};

}  // namespace

SharedUpdate TakeShareStep(const MissionState& state, const Island& island,
                           const MapStoreOptions& options, size_t byte_budget, ShareState& share,
                           LongRead& read) {
  return ShareStep(state, island, options, byte_budget, share, read).Take();
}

}  // namespace corbslam::map_store

// Tests that placing piece by piece, whatever the store says and the robot does meanwhile, ends
// where placing everything at once does.
#include <algorithm>
#include <random>
#include <utility>

#include "client_agent/link/testing/test_payload.h"
#include "client_agent/shared/shared_map.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{1};
constexpr int kKeypoints = 12;
constexpr uint32_t kOwnKeyframes = 4;

PlacementChange Share(const SharedUpdate& update, SharedMap& shared, Map& map) {
  shared.Apply({update, std::vector<std::shared_ptr<const Words>>(update.keyframes.size())});
  return shared.Place(shared.Plan(map), map);
}

std::shared_ptr<const KeyframePayload> Payload(KeyframeId id) {
  return testing::MakeTestPayload(id, kKeypoints);
}

Rigid3d RandomPose(std::mt19937& random, double metres) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Eigen::Vector3d axis(uniform(random), uniform(random), uniform(random));
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.1 * metres * axis.norm(), axis.normalized())),
          metres * Eigen::Vector3d(uniform(random), uniform(random), uniform(random))};
}

// A store's view of two foreign local maps, changed at random, and the robot's own map.
class World {
 public:
  explicit World(unsigned seed) : random_(seed) {
    for (uint32_t k = 0; k < kOwnKeyframes; ++k) {
      Keyframe keyframe;
      keyframe.payload = Payload({kOwn, k});
      keyframe.camera_from_map = RandomPose(random_, 5);
      if (k > 0) keyframe.parent = {kOwn, 0};
      map_.AddKeyframe(std::move(keyframe));
    }
    for (uint32_t p = 0; p < 8; ++p) {
      MapPoint point;
      point.id = {kOwn, p};
      map_.AddPoint(std::move(point));
      for (uint32_t k = 0; k < kOwnKeyframes; ++k) map_.AddObservation({kOwn, p}, {kOwn, k}, p);
    }
  }

  Map& map() { return map_; }

  void Step(SharedUpdate& update) {
    switch (Below(11)) {
      case 0:
      case 1:
        return TellKeyframe(update);
      case 2:
        return MoveSomething(update);
      case 3:
      case 4:
        return ChangeSight(update);
      case 5:
      case 6:
        return MergeLandmarks(update);
      case 7:
        return LeaveLandmark(update);
      case 8:
        return RemoveKeyframe(update);
      case 9:
        return RemovePoint(update);
      default:
        return LoseOwnPoint();
    }
  }

  // Adds to the update what the store says of points that the robot lost.
  void TellLosses(SharedUpdate& update) {
    for (const MapPointId id : std::exchange(lost_, {})) {
      const MapPointId survivor = SurvivorOf(id);
      if (survivor == id) {
        if (landmarks_.contains(id)) Elect(id, update);
        continue;
      }
      std::vector<MapPointId>& members = landmarks_.at(survivor);
      std::erase(members, id);
      update.landmarks.push_back({survivor, members});
      if (members.empty()) landmarks_.erase(survivor);
    }
  }

  // Corrects the robot's own map and the global frame's place in it alike.
  void MoveRobot() {
    const Rigid3d motion = RandomPose(random_, 1);
    for (uint32_t k = 0; k < kOwnKeyframes; ++k) {
      const Keyframe& own = *map_.FindKeyframe({kOwn, k});
      map_.SetPose(own.id(), own.camera_from_map * motion);
    }
    global_from_local_ = global_from_local_ * motion;
  }

  SharedUpdate Everything(bool restart) const {
    SharedUpdate update;
    update.restart = restart;
    for (const auto& [id, keyframe] : keyframes_) update.keyframes.push_back(keyframe);
    for (const auto& [id, point] : points_) update.points.push_back(point);
    for (const auto& [survivor, members] : landmarks_) {
      update.landmarks.push_back({survivor, members});
    }
    AddOwnPoses(update);
    return update;
  }

  void AddOwnPoses(SharedUpdate& update) const {
    for (uint32_t k = 0; k < kOwnKeyframes; ++k) {
      const Rigid3d& camera_from_local = map_.FindKeyframe({kOwn, k})->camera_from_map;
      update.own_keyframes.push_back(
          {{kOwn, k},
           Similarity3d::FromRigid(camera_from_local * global_from_local_.Inverse()),
           camera_from_local});
    }
  }

  size_t Below(size_t count) {
    return std::uniform_int_distribution<size_t>(0, count - 1)(random_);
  }

 private:
  LocalMapId AnySource() { return LocalMapId{2 + Below(2)}; }

  template <typename Items>
  auto Any(const Items& items) {
    return std::next(items.begin(), static_cast<std::ptrdiff_t>(Below(items.size())));
  }

  MapPointId TellPoint(SharedUpdate& update) {
    SharedMapPoint point;
    point.id = {AnySource(), next_point_++};
    point.position_in_global = RandomPose(random_, 20).translation;
    points_[point.id] = point;
    update.points.push_back(point);
    return point.id;
  }

  // Returns a survivor that is told already, or a new one.
  MapPointId AnySurvivor(SharedUpdate& update) {
    if (points_.empty() || Below(3) == 0) return TellPoint(update);
    return Any(points_)->first;
  }

  bool Sees(const SharedKeyframe& keyframe, MapPointId point) const {
    return std::ranges::any_of(keyframe.points, [&](MapPointId seen) {
      return seen.IsValid() && SurvivorOf(seen) == SurvivorOf(point);
    });
  }

  void TellKeyframe(SharedUpdate& update) {
    SharedKeyframe keyframe;
    const KeyframeId id = {AnySource(), next_keyframe_++};
    keyframe.payload = Payload(id);
    keyframe.camera_from_global = Similarity3d::FromRigid(RandomPose(random_, 20));
    // Keyframes are told in any order: the parent may come later, or never.
    keyframe.parent = {id.local_map, static_cast<uint32_t>(Below(next_keyframe_ + 3))};
    if (keyframe.parent == id) keyframe.parent = {};
    keyframe.points.resize(kKeypoints);
    for (size_t k = 0; k < kKeypoints; k += 2) {
      const MapPointId point = AnySurvivor(update);
      if (!Sees(keyframe, point)) keyframe.points[k] = point;
    }
    keyframes_[id] = keyframe;
    update.keyframes.push_back(keyframe);
  }

  void MoveSomething(SharedUpdate& update) {
    if (!keyframes_.empty()) {
      SharedKeyframe& keyframe = keyframes_.at(Any(keyframes_)->first);
      keyframe.camera_from_global = Similarity3d::FromRigid(RandomPose(random_, 20));
      update.moved_keyframes.push_back({keyframe.payload->id, keyframe.camera_from_global});
    }
    if (points_.empty()) return;
    SharedMapPoint& point = points_.at(Any(points_)->first);
    point.position_in_global = RandomPose(random_, 20).translation;
    update.moved_points.push_back({point.id, point.position_in_global});
  }

  void ChangeSight(SharedUpdate& update) {
    if (keyframes_.empty()) return;
    SharedKeyframe& keyframe = keyframes_.at(Any(keyframes_)->first);
    const auto keypoint = static_cast<uint32_t>(Below(kKeypoints));
    MapPointId& seen = keyframe.points[keypoint];
    const KeyframeId id = keyframe.payload->id;
    if (seen.IsValid()) {
      update.observations.push_back({ObservationChange::Kind::kRemoved, seen, id, keypoint});
      seen = {};
    }
    const MapPointId point = AnySurvivor(update);
    if (Sees(keyframe, point)) return;
    seen = point;
    update.observations.push_back({ObservationChange::Kind::kAdded, point, id, keypoint});
  }

  MapPointId SurvivorOf(MapPointId id) const {
    for (const auto& [survivor, members] : landmarks_) {
      if (std::ranges::find(members, id) != members.end()) return survivor;
    }
    return id;
  }

  // Takes one of two points from keyframes that see both: they would see one landmark twice, which
  // the store does not say.
  void Unsee(MapPointId a, MapPointId b, SharedUpdate& update) {
    for (auto& [id, keyframe] : keyframes_) {
      bool seen = false;
      for (uint32_t k = 0; k < kKeypoints; ++k) {
        MapPointId& point = keyframe.points[k];
        if (!point.IsValid()) continue;
        if (SurvivorOf(point) != a && SurvivorOf(point) != b) continue;
        if (std::exchange(seen, true)) {
          update.observations.push_back({ObservationChange::Kind::kRemoved, point, id, k});
          point = {};
        }
      }
    }
  }

  // Has a foreign landmark take in another one, or one of the robot's points.
  void MergeLandmarks(SharedUpdate& update) {
    if (points_.size() < 2) return;
    const MapPointId survivor = Any(points_)->first;
    MapPointId member = Any(points_)->first;
    if (Below(2) == 0) {
      member = SurvivorOf({kOwn, static_cast<uint32_t>(Below(8))});
      if (member.local_map != kOwn) return;
    }
    if (member == survivor) return;
    Unsee(survivor, member, update);
    std::vector<MapPointId> joined = landmarks_[survivor];
    joined.push_back(member);
    if (const auto it = landmarks_.find(member); it != landmarks_.end()) {
      joined.insert(joined.end(), it->second.begin(), it->second.end());
      landmarks_.erase(it);
    }
    points_.erase(member);
    // A point that was told before in this update is a member now.
    std::erase_if(update.points, [&](const SharedMapPoint& point) { return point.id == member; });
    landmarks_[survivor] = joined;
    update.landmarks.push_back({survivor, joined});
  }

  // Has a member's owner delete it.
  void LeaveLandmark(SharedUpdate& update) {
    if (landmarks_.empty()) return;
    auto& [survivor, members] = *Any(landmarks_);
    std::vector<MapPointId>& left = landmarks_.at(survivor);
    const MapPointId gone = left[Below(left.size())];
    std::erase(left, gone);
    UnseePoint(gone, update);
    update.landmarks.push_back({survivor, left});
    if (left.empty()) landmarks_.erase(survivor);
  }

  void UnseePoint(MapPointId gone, SharedUpdate& update) {
    for (auto& [id, keyframe] : keyframes_) {
      for (uint32_t k = 0; k < kKeypoints; ++k) {
        if (keyframe.points[k] != gone) continue;
        update.observations.push_back({ObservationChange::Kind::kRemoved, gone, id, k});
        keyframe.points[k] = {};
      }
    }
  }

  void RemoveKeyframe(SharedUpdate& update) {
    if (keyframes_.size() < 3) return;
    const KeyframeId id = Any(keyframes_)->first;
    // In one update the store says of a keyframe only what is left.
    const auto is_told = [id](const SharedKeyframe& told) { return told.payload->id == id; };
    if (std::ranges::any_of(update.keyframes, is_told)) return;
    keyframes_.erase(id);
    update.removed_keyframes.push_back(id);
  }

  // Has a point's owner delete it: another point of its landmark becomes the survivor.
  void RemovePoint(SharedUpdate& update) {
    if (points_.empty()) return;
    const MapPointId id = Any(points_)->first;
    const auto is_told = [id](const SharedMapPoint& told) { return told.id == id; };
    if (std::ranges::any_of(update.points, is_told)) return;
    UnseePoint(id, update);
    points_.erase(id);
    update.removed_points.push_back(id);
    if (landmarks_.contains(id)) Elect(id, update);
  }

  void Elect(MapPointId gone, SharedUpdate& update) {
    std::vector<MapPointId> left = landmarks_.at(gone);
    landmarks_.erase(gone);
    const MapPointId elected = left.front();
    left.erase(left.begin());
    // An update says what is, not what was on the way.
    std::erase_if(update.landmarks, [gone](const Landmark& told) { return told.survivor == gone; });
    if (elected.local_map != kOwn) {
      SharedMapPoint point;
      point.id = elected;
      point.position_in_global = RandomPose(random_, 20).translation;
      points_[elected] = point;
      update.points.push_back(point);
    }
    if (left.empty()) return;
    landmarks_[elected] = left;
    update.landmarks.push_back({elected, left});
  }

  // Has the robot cull a point; the store hears of it, and says so, later.
  void LoseOwnPoint() {
    std::vector<MapPointId> own;
    for (const auto& [id, point] : map_.points()) {
      if (id.local_map == kOwn) own.push_back(id);
    }
    if (own.size() < 4) return;
    lost_.push_back(own[Below(own.size())]);
    map_.RemovePoint(lost_.back());
  }

  std::mt19937 random_;
  Map map_;
  Rigid3d global_from_local_ = RandomPose(random_, 30);
  uint32_t next_keyframe_ = 0;
  uint32_t next_point_ = 0;
  std::map<KeyframeId, SharedKeyframe> keyframes_;
  std::map<MapPointId, SharedMapPoint> points_;
  std::map<MapPointId, std::vector<MapPointId>> landmarks_;
  std::vector<MapPointId> lost_;
};

Map WithoutForeign(Map map) {
  const Map all = map;
  for (const auto& [id, keyframe] : all.keyframes()) {
    if (id.local_map != kOwn) map.RemoveKeyframe(id);
  }
  for (const auto& [id, point] : all.points()) {
    if (id.local_map != kOwn) map.RemovePoint(id);
  }
  return map;
}

void ExpectSame(const Map& map, const Map& wanted) {
  ASSERT_EQ(map.keyframes().size(), wanted.keyframes().size());
  ASSERT_EQ(map.points().size(), wanted.points().size());
  for (const auto& [id, keyframe] : wanted.keyframes()) {
    const Keyframe* held = map.FindKeyframe(id);
    ASSERT_NE(held, nullptr) << ToString(id);
    EXPECT_EQ(held->points, keyframe.points) << ToString(id);
    EXPECT_EQ(held->covisible, keyframe.covisible) << ToString(id);
    const Rigid3d difference = held->camera_from_map * keyframe.camera_from_map.Inverse();
    EXPECT_LT(difference.translation.norm(), 1e-3) << ToString(id);
  }
  for (const auto& [id, point] : wanted.points()) {
    const MapPoint* held = map.FindPoint(id);
    ASSERT_NE(held, nullptr) << ToString(id);
    EXPECT_LT((held->position_in_map - point.position_in_map).norm(), 1e-3) << ToString(id);
  }
}

class SharedMapRandomTest : public ::testing::TestWithParam<unsigned> {};

TEST_P(SharedMapRandomTest, PieceByPieceIsAsAllAtOnce) {
  World world(GetParam());
  SharedMap shared(kOwn);
  for (int round = 0; round < 60; ++round) {
    SharedUpdate update;
    for (size_t step = world.Below(8); step > 0; --step) world.Step(update);
    world.TellLosses(update);
    if (world.Below(5) == 0) world.MoveRobot();
    world.AddOwnPoses(update);
    const bool restart = world.Below(15) == 0;
    Share(restart ? world.Everything(true) : update, shared, world.map());

    SharedMap fresh(kOwn);
    Map all_at_once = WithoutForeign(world.map());
    Share(world.Everything(false), fresh, all_at_once);
    ExpectSame(world.map(), all_at_once);
    if (HasFailure()) FAIL() << "round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SharedMapRandomTest, ::testing::Range(0u, 40u),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace corbslam::client_agent

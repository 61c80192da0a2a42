#include "client_agent/shared/shared_map.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "client_agent/link/testing/test_payload.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{1};
constexpr LocalMapId kForeign{2};
constexpr int kKeypoints = 20;

// The pose of the robot's own frame in the global one.
const Rigid3d kGlobalFromLocal = {
    Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY())), {10, 0, -3}};

std::shared_ptr<const KeyframePayload> Payload(KeyframeId id) {
  return testing::MakeTestPayload(id, kKeypoints);
}

Rigid3d CameraAt(double x) { return {Eigen::Quaterniond::Identity(), {-x, 0, 0}}; }

// Returns a map with own keyframes 0 to 2 at x = 0, 1, 2 and points 0 to 9 seen by all.
Map OwnMap() {
  Map map;
  for (uint32_t k = 0; k < 3; ++k) {
    Keyframe keyframe;
    keyframe.payload = Payload({kOwn, k});
    keyframe.camera_from_map = CameraAt(k);
    if (k > 0) keyframe.parent = {kOwn, k - 1};
    map.AddKeyframe(keyframe);
  }
  for (uint32_t p = 0; p < 10; ++p) {
    MapPoint point;
    point.id = {kOwn, p};
    point.position_in_map = {0.1 * p, 0.5, 6};
    map.AddPoint(point);
    for (uint32_t k = 0; k < 3; ++k) map.AddObservation(point.id, {kOwn, k}, p);
  }
  return map;
}

// Returns an update with one foreign keyframe at x = 3 (of the robot's frame) and foreign points 0
// to 9, of which 0 to 4 are one landmark each with own points 0 to 4.
SharedUpdate FirstUpdate() {
  SharedUpdate update;
  update.revision = 4;
  const Rigid3d local_from_global = kGlobalFromLocal.Inverse();
  SharedKeyframe keyframe;
  keyframe.payload = Payload({kForeign, 0});
  keyframe.camera_from_global = Similarity3d::FromRigid(CameraAt(3) * local_from_global);
  keyframe.points.resize(kKeypoints);
  for (uint32_t p = 0; p < 10; ++p) {
    SharedMapPoint point;
    point.id = {kForeign, p};
    point.position_in_global = kGlobalFromLocal * Eigen::Vector3d(0.1 * p, 0.5, 6);
    point.normal_in_global = kGlobalFromLocal.rotation * Eigen::Vector3d::UnitZ();
    update.points.push_back(point);
    keyframe.points[p] = point.id;
  }
  update.keyframes.push_back(keyframe);
  for (uint32_t p = 0; p < 5; ++p) update.landmarks.push_back({{kForeign, p}, {{kOwn, p}}});
  for (uint32_t k = 0; k < 3; ++k) {
    update.own_keyframes.push_back(
        {{kOwn, k}, Similarity3d::FromRigid(CameraAt(k) * local_from_global), CameraAt(k)});
  }
  return update;
}

class SharedMapTest : public ::testing::Test {
 protected:
  void Apply(const SharedUpdate& update) {
    std::vector<std::shared_ptr<const Words>> words(update.keyframes.size(),
                                                    std::make_shared<Words>());
    shared_.Apply({update, std::move(words)});
  }
  PlacementChange Share(const SharedUpdate& update) {
    Apply(update);
    return shared_.Place(shared_.Plan(map_), map_);
  }

  // Moves the robot's own keyframes by so much along x.
  void Correct(double shift, absl::btree_set<KeyframeId> fixed = {}) {
    OwnCorrection correction;
    correction.fixed = std::move(fixed);
    for (uint32_t k = 0; k < 3; ++k) {
      const Rigid3d before = map_.FindKeyframe({kOwn, k})->camera_from_map;
      const Rigid3d after = {before.rotation,
                             before.translation - shift * Eigen::Vector3d::UnitX()};
      map_.SetPose({kOwn, k}, after);
      correction.motions[{kOwn, k}] = {before, after};
    }
    shared_.Correct(correction, map_);
    shared_.Place(shared_.Plan(map_), map_);
  }

  // Shares a foreign keyframe that shares no point with own ones.
  void ShareWithoutLandmarks() {
    SharedUpdate update = FirstUpdate();
    update.landmarks.clear();
    Share(update);
  }

  // Returns FirstUpdate's global poses, derived from local poses so far along x.
  static SharedUpdate OwnPoses(double shift) {
    SharedUpdate update;
    update.own_keyframes = FirstUpdate().own_keyframes;
    for (OwnKeyframePose& pose : update.own_keyframes) {
      pose.camera_from_local.translation.x() -= shift;
    }
    return update;
  }

  Eigen::Vector3d CentreOf(KeyframeId id) const {
    return CameraCentre(map_.FindKeyframe(id)->camera_from_map);
  }

  Map map_ = OwnMap();
  SharedMap shared_{kOwn};
};

TEST_F(SharedMapTest, ForeignItemsArePlacedInTheRobotsFrame) {
  const PlacementChange change = Share(FirstUpdate());
  ASSERT_EQ(change.added_keyframes.size(), 1U);
  const Keyframe& foreign = *map_.FindKeyframe({kForeign, 0});
  EXPECT_LT((CameraCentre(foreign.camera_from_map) - Eigen::Vector3d(3, 0, 0)).norm(), 1e-9);
  const MapPoint& point = *map_.FindPoint({kForeign, 7});
  EXPECT_LT((point.position_in_map - Eigen::Vector3d(0.7, 0.5, 6)).norm(), 1e-9);
  EXPECT_LT((point.normal_in_map - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  const Similarity3d global_from_local = *shared_.GlobalFromLocal();
  EXPECT_LT((global_from_local.translation - kGlobalFromLocal.translation).norm(), 1e-9);
}

TEST_F(SharedMapTest, ARobotAloneLiesWhereTheStoreSaysUntilFusionPlacesItsKeyframes) {
  EXPECT_FALSE(shared_.GlobalFromLocal().has_value());
  SharedUpdate alone;
  alone.global_from_local = Similarity3d::Identity();
  Share(alone);
  ASSERT_TRUE(shared_.GlobalFromLocal().has_value());
  EXPECT_EQ(shared_.GlobalFromLocal()->translation.norm(), 0);
  // A loop that the robot closes moves its keyframes, and not its frame.
  Correct(0.5);
  EXPECT_EQ(shared_.GlobalFromLocal()->translation.norm(), 0);
  EXPECT_EQ(map_.keyframes().size(), 3u);
  Share(FirstUpdate());
  EXPECT_GT(shared_.GlobalFromLocal()->translation.norm(), 5);
}

TEST_F(SharedMapTest, ForgettingAllItForgetsWhereItLies) {
  SharedUpdate alone;
  alone.global_from_local = Similarity3d::Identity();
  Share(alone);
  SharedUpdate restart;
  restart.restart = true;
  Share(restart);
  EXPECT_FALSE(shared_.GlobalFromLocal().has_value());
  restart.global_from_local = Similarity3d::Identity();
  Share(restart);
  EXPECT_TRUE(shared_.GlobalFromLocal().has_value());
}

TEST_F(SharedMapTest, ApartFromTheGlobalFrameOthersArePlacedAndNoGlobalPoseIsKnown) {
  SharedUpdate apart = FirstUpdate();
  apart.apart = true;
  EXPECT_EQ(Share(apart).added_keyframes.size(), 1u);
  EXPECT_FALSE(shared_.GlobalFromLocal().has_value());
  SharedUpdate connected;
  connected.revision = 5;
  Share(connected);
  EXPECT_TRUE(shared_.GlobalFromLocal().has_value());
}

TEST_F(SharedMapTest, ALandmarkTheRobotHoldsIsNotHeldTwice) {
  Share(FirstUpdate());
  EXPECT_EQ(map_.FindPoint({kForeign, 2}), nullptr);
  EXPECT_EQ(map_.FindPoint({kOwn, 2})->observations.at({kForeign, 0}), 2U);
  EXPECT_EQ(map_.FindKeyframe({kOwn, 0})->covisible.at({kForeign, 0}), 5);
}

TEST_F(SharedMapTest, PlacesEachKeyframeByTheOwnOneNearestToItWhateverTheDriftElsewhere) {
  SharedUpdate update = FirstUpdate();
  // This keyframe is behind the robot's first one; foreign keyframe 0 is ahead of its last.
  SharedKeyframe behind = update.keyframes[0];
  behind.payload = Payload({kForeign, 1});
  behind.camera_from_global = Similarity3d::FromRigid(CameraAt(-1) * kGlobalFromLocal.Inverse());
  behind.points.assign(kKeypoints, {});
  update.keyframes.push_back(behind);
  // The robot drifted between keyframes 1 and 2, which fusion has corrected.
  map_.SetPose({kOwn, 2}, CameraAt(2.5));
  update.own_keyframes[2].camera_from_local = CameraAt(2.5);
  Share(update);
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3.5, 1e-9);
  EXPECT_NEAR(CentreOf({kForeign, 1}).x(), -1, 1e-9);
  EXPECT_NEAR(map_.FindPoint({kForeign, 7})->position_in_map.x(), 0.7 + 0.5, 1e-9);
}

TEST_F(SharedMapTest, WhatTheRobotAdjustsDoesNotMoveWhatItIsAdjustedTo) {
  Share(FirstUpdate());
  for (uint32_t k = 0; k < 3; ++k) map_.SetPose({kOwn, k}, CameraAt(k + 0.1));
  Share({});
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3, 1e-9);
}

TEST_F(SharedMapTest, WhatNothingHoldsIsWhereTheNearestOwnKeyframeSaysAfterACorrection) {
  ShareWithoutLandmarks();
  Correct(0.5);
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3.5, 1e-9);
  EXPECT_NEAR(map_.FindPoint({kForeign, 7})->position_in_map.x(), 1.2, 1e-9);
  EXPECT_NEAR(shared_.GlobalFromLocal()->Inverse().translation.x(),
              kGlobalFromLocal.Inverse().translation.x() + 0.5, 1e-9);
  // The store says again what it derived before it knew of the correction, then what it derives
  // from it.
  Share(OwnPoses(0));
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3.5, 1e-9);
  Share(OwnPoses(0.5));
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3.5, 1e-9);
}

TEST_F(SharedMapTest, OfSeveralCorrectionsThoseCountThatTheStoreDoesNotKnow) {
  ShareWithoutLandmarks();
  Correct(0.5);
  Correct(0.25);
  // The store knows the first correction alone.
  Share(OwnPoses(0.5));
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3.75, 1e-9);
  Share(OwnPoses(0.75));
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3.75, 1e-9);
}

TEST_F(SharedMapTest, NothingMovesUntilAllThatMovedIsTold) {
  ShareWithoutLandmarks();
  // The global frame goes elsewhere: the store tells it of own keyframes first, then of others'.
  const Rigid3d before_from_after = {Eigen::Quaterniond::Identity(), {0, 7, 0}};
  SharedUpdate first = OwnPoses(0);
  first.more_places = true;
  for (OwnKeyframePose& pose : first.own_keyframes) {
    pose.camera_from_global = pose.camera_from_global * Similarity3d::FromRigid(before_from_after);
  }
  SharedUpdate second;
  second.moved_keyframes.push_back(
      {{kForeign, 0},
       Similarity3d::FromRigid(CameraAt(3) * kGlobalFromLocal.Inverse() * before_from_after)});
  Share(first);
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3, 1e-9);
  EXPECT_NEAR(CentreOf({kForeign, 0}).y(), 0, 1e-9);
  Share(second);
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3, 1e-9);
  EXPECT_NEAR(CentreOf({kForeign, 0}).y(), 0, 1e-9);
}

TEST_F(SharedMapTest, AKeyframeThatTheRobotCulledPlacesNothing) {
  SharedUpdate update = FirstUpdate();
  update.own_keyframes[2].camera_from_local = CameraAt(2.5);
  map_.RemoveKeyframe({kOwn, 2});
  Share(update);
  EXPECT_NEAR(CentreOf({kForeign, 0}).x(), 3, 1e-9);
}

TEST_F(SharedMapTest, MovesAreFollowedAndNothingIsPlacedBeforeFusion) {
  SharedUpdate update = FirstUpdate();
  const auto own_keyframes = std::exchange(update.own_keyframes, {});
  Apply(update);
  EXPECT_TRUE(shared_.Place(shared_.Plan(map_), map_).added_keyframes.empty());
  EXPECT_FALSE(shared_.GlobalFromLocal().has_value());

  SharedUpdate next;
  next.revision = 5;
  next.own_keyframes = own_keyframes;
  next.moved_keyframes.push_back(
      {{kForeign, 0}, Similarity3d::FromRigid(CameraAt(4) * kGlobalFromLocal.Inverse())});
  next.moved_points.push_back({{kForeign, 7}, kGlobalFromLocal * Eigen::Vector3d(1, 2, 3)});
  Share(next);
  EXPECT_NEAR(CameraCentre(map_.FindKeyframe({kForeign, 0})->camera_from_map).x(), 4, 1e-9);
  EXPECT_LT((map_.FindPoint({kForeign, 7})->position_in_map - Eigen::Vector3d(1, 2, 3)).norm(),
            1e-9);
}

TEST_F(SharedMapTest, OwnItemsAreNeverMoved) {
  const Map before = map_;
  Share(FirstUpdate());
  for (const auto& [id, keyframe] : before.keyframes()) {
    EXPECT_EQ(map_.FindKeyframe(id)->camera_from_map.translation,
              keyframe.camera_from_map.translation);
  }
  for (const auto& [id, point] : before.points()) {
    EXPECT_EQ(map_.FindPoint(id)->position_in_map, point.position_in_map);
  }
}

TEST_F(SharedMapTest, RemovedItemsAndRestartLeaveNothingBehind) {
  Share(FirstUpdate());
  SharedUpdate next;
  next.removed_points.push_back({kForeign, 7});
  Share(next);
  EXPECT_EQ(map_.FindPoint({kForeign, 7}), nullptr);
  EXPECT_NE(map_.FindPoint({kForeign, 8}), nullptr);
  SharedUpdate restart;
  restart.restart = true;
  const PlacementChange change = Share(restart);
  EXPECT_EQ(change.removed_keyframes, (std::vector<KeyframeId>{{kForeign, 0}}));
  EXPECT_EQ(map_.keyframes().size(), 3U);
  EXPECT_EQ(map_.points().size(), 10U);
}

TEST_F(SharedMapTest, ARestartLeavesOwnKeyframesWhatTheySee) {
  Share(FirstUpdate());
  EXPECT_TRUE(map_.AddObservation({kForeign, 9}, {kOwn, 2}, 15));
  SharedUpdate again = FirstUpdate();
  again.restart = true;
  const PlacementChange change = Share(again);
  EXPECT_TRUE(change.removed_keyframes.empty());
  EXPECT_TRUE(change.added_keyframes.empty());
  EXPECT_EQ(map_.FindKeyframe({kOwn, 2})->points[15], (MapPointId{kForeign, 9}));
}

TEST_F(SharedMapTest, WhatComesBeforeAnyPlaceForItIsPlacedOnceThereIsOne) {
  SharedUpdate first = FirstUpdate();
  const std::vector<OwnKeyframePose> placed = std::exchange(first.own_keyframes, {});
  // The global frame is the robot's own here, so that nothing moves when it becomes known.
  for (SharedKeyframe& keyframe : first.keyframes) {
    keyframe.camera_from_global = Similarity3d::FromRigid(CameraAt(3));
  }
  Share(first);
  EXPECT_EQ(map_.FindKeyframe({kForeign, 0}), nullptr);
  SharedUpdate then;
  for (uint32_t k = 0; k < 3; ++k) {
    then.own_keyframes.push_back({{kOwn, k}, Similarity3d::FromRigid(CameraAt(k)), CameraAt(k)});
  }
  ASSERT_EQ(placed.size(), then.own_keyframes.size());
  Share(then);
  EXPECT_NE(map_.FindKeyframe({kForeign, 0}), nullptr);
}

TEST_F(SharedMapTest, APointLaterFoundToBeTheRobotsOwnGoesOverToIt) {
  Share(FirstUpdate());
  EXPECT_TRUE(map_.AddObservation({kForeign, 9}, {kOwn, 2}, 15));
  SharedUpdate next;
  next.landmarks.push_back({{kForeign, 9}, {{kOwn, 9}}});
  Share(next);
  EXPECT_EQ(map_.FindPoint({kForeign, 9}), nullptr);
  EXPECT_EQ(map_.FindPoint({kOwn, 9})->observations.at({kForeign, 0}), 9U);
}

TEST_F(SharedMapTest, APointThatTheRobotGaveAwayComesBackWithWhoSeesIt) {
  Share(FirstUpdate());
  ASSERT_TRUE(map_.ReplacePoint({kForeign, 7}, {kForeign, 8}));
  // The robot's map moves, and with it what foreign items are placed by.
  Correct(0.1);
  ASSERT_NE(map_.FindPoint({kForeign, 7}), nullptr);
  EXPECT_EQ(map_.FindKeyframe({kForeign, 0})->points[7], (MapPointId{kForeign, 7}));
}

TEST_F(SharedMapTest, AParentThatComesAfterItsChildIsItsParent) {
  SharedUpdate first = FirstUpdate();
  first.keyframes[0].parent = {kForeign, 1};
  Share(first);
  EXPECT_FALSE(map_.FindKeyframe({kForeign, 0})->parent.IsValid());
  SharedUpdate next;
  next.keyframes = first.keyframes;
  next.keyframes[0].payload = Payload({kForeign, 1});
  next.keyframes[0].parent = {};
  Share(next);
  EXPECT_EQ(map_.FindKeyframe({kForeign, 0})->parent, (KeyframeId{kForeign, 1}));
}

TEST_F(SharedMapTest, APointThatLeavesALandmarkToLeadAnotherStandsForTheFirstNoMore) {
  Share(FirstUpdate());
  SharedUpdate next;
  next.landmarks.push_back({{kOwn, 2}, {{kForeign, 8}}});
  Share(next);
  const Keyframe& foreign = *map_.FindKeyframe({kForeign, 0});
  EXPECT_EQ(foreign.points[2], (MapPointId{kForeign, 2}));
  EXPECT_EQ(foreign.points[8], (MapPointId{kOwn, 2}));
}

class LeavingOutTest : public SharedMapTest {
 protected:
  // Shares the foreign keyframe and its points; own keyframes 0 and 1 see point 7, and keyframe 0
  // alone sees point 8.
  LeavingOutTest() {
    Share(FirstUpdate());
    map_.AddObservation({kForeign, 7}, {kOwn, 0}, 17);
    map_.AddObservation({kForeign, 7}, {kOwn, 1}, 17);
    map_.AddObservation({kForeign, 8}, {kOwn, 0}, 18);
    place_ = map_.FindPoint({kForeign, 7})->position_in_map;
  }
  PlacementChange LeaveOut() {
    shared_.LeaveOut(
        kForeign,
        [this] {
          return MapPointId{kOwn, next_++};
        },
        map_);
    return shared_.Place(shared_.Plan(map_), map_);
  }
  bool HoldsForeign() const {
    const auto is_foreign = [](const auto& item) { return item.first.local_map == kForeign; };
    return std::ranges::any_of(map_.keyframes(), is_foreign) ||
           std::ranges::any_of(map_.points(), is_foreign);
  }

  uint32_t next_ = 100;
  Eigen::Vector3d place_;
};

TEST_F(LeavingOutTest, WhatOwnKeyframesLocateBecomesOwnAndTheRestGoes) {
  const PlacementChange change = LeaveOut();
  EXPECT_EQ(change.removed_keyframes, std::vector<KeyframeId>({{kForeign, 0}}));
  EXPECT_EQ(change.released_keyframes, std::vector<KeyframeId>({{kOwn, 0}, {kOwn, 1}}));
  EXPECT_FALSE(HoldsForeign());
  const MapPoint* kept = map_.FindPoint({kOwn, 100});
  ASSERT_NE(kept, nullptr);
  EXPECT_EQ(kept->position_in_map, place_);
  EXPECT_EQ(kept->observations.size(), 2u);
  EXPECT_EQ(map_.FindKeyframe({kOwn, 1})->points[17], kept->id);
  EXPECT_EQ(map_.FindPoint({kOwn, 101}), nullptr) << "one look without a depth locates nothing";
  EXPECT_FALSE(map_.FindKeyframe({kOwn, 0})->points[18].IsValid());
  EXPECT_EQ(map_.FindPoint({kOwn, 2})->observations.size(), 3u) << "own points stay";
}

TEST_F(LeavingOutTest, NothingOfItComesAgain) {
  LeaveOut();
  Share(FirstUpdate());
  EXPECT_FALSE(HoldsForeign());
  SharedUpdate anew = FirstUpdate();
  anew.restart = true;
  Share(anew);
  EXPECT_FALSE(HoldsForeign());
}

TEST_F(LeavingOutTest, WhatAThirdRobotMadeIsTaken) {
  LeaveOut();
  SharedUpdate update;
  update.keyframes = FirstUpdate().keyframes;
  update.keyframes[0].payload = Payload({LocalMapId{3}, 0});
  for (MapPointId& point : update.keyframes[0].points) point = {};
  Share(update);
  EXPECT_NE(map_.FindKeyframe({LocalMapId{3}, 0}), nullptr);
}

}  // namespace
}  // namespace corbslam::client_agent

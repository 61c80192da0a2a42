// Tests that the robot's sight says where others' keyframes lie, wherever the robot saw what they
// saw.
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "client_agent/shared/shared_map.h"
#include "slam/camera/testing/test_camera.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{1};
constexpr LocalMapId kForeign{2};
constexpr uint32_t kOwnKeyframes = 3;
constexpr uint32_t kPoints = 30;
// The other robot found so many of the points, too.
constexpr uint32_t kShared = 20;

// The global frame is the robot's own, until something drifts.
Rigid3d CameraAt(double x) { return {Eigen::Quaterniond::Identity(), {-x, 0, 0}}; }

Eigen::Vector3d PointAt(uint32_t index) { return {0.2 * index, 0.3, 6}; }

// Returns the payload of a camera at x that sees all the points where they are.
std::shared_ptr<const KeyframePayload> Payload(KeyframeId id, double x) {
  Features features;
  features.keypoints.resize(kPoints);
  features.descriptors.resize(kPoints);
  for (uint32_t p = 0; p < kPoints; ++p) {
    const Eigen::Vector2d pixel = Project(*testing::TestCamera(), CameraAt(x) * PointAt(p));
    features.keypoints[p].x_px = static_cast<float>(pixel.x());
    features.keypoints[p].y_px = static_cast<float>(pixel.y());
  }
  return MakeKeyframePayload(id, 0, 0, testing::TestCamera(), std::move(features));
}

// Returns a map with own keyframes at x = 0, 1, 2 that see all points.
Map OwnMap() {
  Map map;
  for (uint32_t k = 0; k < kOwnKeyframes; ++k) {
    Keyframe keyframe;
    keyframe.payload = Payload({kOwn, k}, k);
    keyframe.camera_from_map = CameraAt(k);
    if (k > 0) keyframe.parent = {kOwn, k - 1};
    map.AddKeyframe(std::move(keyframe));
  }
  for (uint32_t p = 0; p < kPoints; ++p) {
    MapPoint point;
    point.id = {kOwn, p};
    point.position_in_map = PointAt(p);
    map.AddPoint(std::move(point));
    for (uint32_t k = 0; k < kOwnKeyframes; ++k) map.AddObservation({kOwn, p}, {kOwn, k}, p);
  }
  return map;
}

class SharedMapContactTest : public ::testing::Test {
 protected:
  // Foreign keyframe 0 at x = 3 saw the shared points; keyframe 1 at x = 4 saw none of them. The
  // store has both too far along x by `error`.
  SharedUpdate ForeignKeyframes(double error) const {
    SharedUpdate update;
    for (uint32_t k = 0; k < 2; ++k) {
      SharedKeyframe keyframe;
      keyframe.payload = Payload({kForeign, k}, 3 + k);
      keyframe.camera_from_global = Similarity3d::FromRigid(CameraAt(3 + k + error));
      keyframe.points.resize(kPoints);
      update.keyframes.push_back(std::move(keyframe));
    }
    for (uint32_t p = 0; p < kShared; ++p) update.keyframes[0].points[p] = {kOwn, p};
    AddOwnPoses(update);
    return update;
  }

  SharedUpdate ForeignMoves(double error) const {
    SharedUpdate update;
    for (uint32_t k = 0; k < 2; ++k) {
      update.moved_keyframes.push_back(
          {{kForeign, k}, Similarity3d::FromRigid(CameraAt(3 + k + error))});
    }
    AddOwnPoses(update);
    return update;
  }

  static void AddOwnPoses(SharedUpdate& update) {
    for (uint32_t k = 0; k < kOwnKeyframes; ++k) {
      update.own_keyframes.push_back(
          {{kOwn, k}, Similarity3d::FromRigid(CameraAt(k)), CameraAt(k)});
    }
  }

  void Share(const SharedUpdate& update) {
    std::vector<std::shared_ptr<const Words>> words(update.keyframes.size(),
                                                    std::make_shared<Words>());
    shared_.Apply({update, std::move(words)});
    shared_.Place(shared_.Plan(map_), map_);
  }

  // Moves the robot's whole map so far along x.
  void Correct(double shift, absl::btree_set<KeyframeId> fixed) {
    OwnCorrection correction;
    correction.fixed = std::move(fixed);
    for (uint32_t k = 0; k < kOwnKeyframes; ++k) {
      const Rigid3d before = map_.FindKeyframe({kOwn, k})->camera_from_map;
      const Rigid3d after = {before.rotation, before.translation - Eigen::Vector3d(shift, 0, 0)};
      map_.SetPose({kOwn, k}, after);
      correction.motions[{kOwn, k}] = {before, after};
    }
    for (uint32_t p = 0; p < kPoints; ++p) {
      map_.SetPosition({kOwn, p}, PointAt(p) + Eigen::Vector3d(shift, 0, 0));
    }
    shared_.Correct(correction, map_);
    shared_.Place(shared_.Plan(map_), map_);
  }

  double XOf(KeyframeId id) const {
    return CameraCentre(map_.FindKeyframe(id)->camera_from_map).x();
  }

  Map map_ = OwnMap();
  SharedMap shared_{kOwn};
};

TEST_F(SharedMapContactTest, WhatTheRobotsSightHoldsStaysWhateverTheStoreSaysOfIt) {
  Share(ForeignKeyframes(0));
  EXPECT_NEAR(XOf({kForeign, 0}), 3, 1e-9);
  // Fusion has placed both by their odometry for now.
  Share(ForeignMoves(1));
  EXPECT_NEAR(XOf({kForeign, 0}), 3, 1e-9);
  EXPECT_NEAR(XOf({kForeign, 1}), 4, 1e-9) << "keeps its place beside the one that is pinned";
}

TEST_F(SharedMapContactTest, WhatDoesNotFitTheRobotsSightIsNotHeld) {
  Share(ForeignKeyframes(1));
  EXPECT_NEAR(XOf({kForeign, 0}), 4, 1e-9);
  Share(ForeignMoves(0));
  EXPECT_NEAR(XOf({kForeign, 0}), 3, 1e-9);
  EXPECT_NEAR(XOf({kForeign, 1}), 4, 1e-9);
}

TEST_F(SharedMapContactTest, WhatTheRobotsSightHoldsNoLongerGoesWhereTheStoreSays) {
  Share(ForeignKeyframes(0));
  // The robot adjusts its keyframes away from the points.
  for (uint32_t k = 0; k < kOwnKeyframes; ++k) map_.SetPose({kOwn, k}, CameraAt(k + 0.5));
  Share(ForeignMoves(1));
  EXPECT_NEAR(XOf({kForeign, 0}), 4, 1e-9);
}

TEST_F(SharedMapContactTest, WhatIsHeldGoesWithTheOwnKeyframesThatHoldIt) {
  Share(ForeignKeyframes(0));
  Correct(0.5, {});
  EXPECT_NEAR(XOf({kForeign, 0}), 3.5, 1e-9);
  EXPECT_NEAR(XOf({kForeign, 1}), 4.5, 1e-9);
  // The store does not know of the correction yet.
  Share(ForeignMoves(0));
  EXPECT_NEAR(XOf({kForeign, 0}), 3.5, 1e-9);
}

TEST_F(SharedMapContactTest, WhatTheLoopItselfMadeSeenStays) {
  // The store has the robot 0.5 m behind where its loop will bring it. Nothing is seen in common
  // yet.
  SharedUpdate update = ForeignKeyframes(0.5);
  std::vector<MapPointId> seen;
  std::swap(seen, update.keyframes[0].points);
  update.keyframes[0].points.resize(kPoints);
  Share(update);
  EXPECT_NEAR(XOf({kForeign, 0}), 3.5, 1e-9);
  // The loop merges points, so that the foreign keyframe sees own ones.
  for (uint32_t p = 0; p < kShared; ++p) map_.AddObservation(seen[p], {kForeign, 0}, p);
  Correct(0.5, {});
  EXPECT_NEAR(XOf({kForeign, 0}), 3.5, 1e-9);
}

TEST_F(SharedMapContactTest, WhatTheOwnMapWasFittedToStays) {
  Share(ForeignKeyframes(0.5));
  EXPECT_NEAR(XOf({kForeign, 0}), 3.5, 1e-9);
  Correct(0.5, {{kForeign, 0}});
  EXPECT_NEAR(XOf({kForeign, 0}), 3.5, 1e-9);
  EXPECT_NEAR(XOf({kForeign, 1}), 4.5, 1e-9);
}

TEST_F(SharedMapContactTest, OwnKeyframesThatSeeOthersPointsHoldThem) {
  SharedUpdate update = ForeignKeyframes(0);
  for (uint32_t p = 0; p < kShared; ++p) {
    SharedMapPoint point;
    point.id = {kForeign, p};
    point.reference = {kForeign, 0};
    point.position_in_global = PointAt(p);
    update.points.push_back(point);
    update.keyframes[0].points[p] = point.id;
  }
  for (uint32_t p = 0; p < kPoints; ++p) map_.RemovePoint({kOwn, p});
  Share(update);
  for (uint32_t p = 0; p < kShared; ++p) {
    ASSERT_TRUE(map_.AddObservation({kForeign, p}, {kOwn, 2}, p));
  }
  SharedUpdate moves = ForeignMoves(1);
  for (uint32_t p = 0; p < kShared; ++p) {
    moves.moved_points.push_back({{kForeign, p}, PointAt(p) + Eigen::Vector3d::UnitX()});
  }
  Share(moves);
  EXPECT_NEAR(XOf({kForeign, 0}), 3, 1e-9);
  EXPECT_NEAR(map_.FindPoint({kForeign, 7})->position_in_map.x(), PointAt(7).x(), 1e-9);
}

}  // namespace
}  // namespace corbslam::client_agent

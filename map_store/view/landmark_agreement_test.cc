#include "map_store/view/landmark_agreement.h"

#include <gtest/gtest.h>

#include <utility>

#include "slam/camera/testing/test_camera.h"

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kMapA = {0xa};
constexpr LocalMapId kMapB = {0xb};
constexpr KeyframeId kOfA = {kMapA, 0};
constexpr KeyframeId kOfB = {kMapB, 0};
constexpr uint32_t kPoints = 21;

Eigen::Vector3d PointAt(uint32_t index) { return {0.1 * index - 1, 0.2, 5}; }

// A keyframe in each of two local maps, both at their origins, that see the same points: B's
// keyframe sees A's points.
class LandmarkAgreementTest : public ::testing::Test {
 protected:
  LandmarkAgreementTest() {
    for (const LocalMapId& id : {kMapA, kMapB}) AddKeyframe(id);
    state_.global.island_of[kMapB] = kMapA;
    state_.global.islands.erase(kMapB);
    state_.global.islands.at(kMapA).local_maps = {kMapA, kMapB};
    LocalMapState& a = *state_.FindLocalMap(kMapA);
    for (uint32_t p = 0; p < kPoints; ++p) {
      MapPoint point;
      point.id = {kMapA, p};
      point.position_in_map = PointAt(p);
      point.reference = kOfA;
      a.map.AddPoint(std::move(point));
      a.map.AddObservation({kMapA, p}, kOfA, p);
    }
  }

  void AddKeyframe(LocalMapId id) {
    LocalMapState& local_map = AddLocalMap(state_, id, "agent");
    Features features;
    features.keypoints.resize(kPoints);
    features.descriptors.resize(kPoints);
    for (uint32_t p = 0; p < kPoints; ++p) {
      const Eigen::Vector2d pixel = Project(*testing::TestCamera(), PointAt(p));
      features.keypoints[p].x_px = static_cast<float>(pixel.x());
      features.keypoints[p].y_px = static_cast<float>(pixel.y());
    }
    Keyframe keyframe;
    keyframe.payload =
        MakeKeyframePayload({id, 0}, 0, 0, testing::TestCamera(), std::move(features));
    local_map.map.AddKeyframe(std::move(keyframe));
  }

  void SeePointsOfA() {
    for (uint32_t p = 0; p < kPoints; ++p) {
      state_.FindLocalMap(kMapB)->foreign_observations[kOfB][p] = {kMapA, p};
    }
  }

  double Disagreement_px(KeyframeId a, KeyframeId b) const {
    const std::vector<SharedLandmark> shared = FindSharedLandmarks(state_, a, b);
    EXPECT_EQ(shared.size(), kPoints);
    return LandmarkDisagreementPx(state_, a, b, shared);
  }

  MissionState state_;
};

TEST_F(LandmarkAgreementTest, ThereIsNoneWithoutSharedLandmarks) {
  EXPECT_TRUE(FindSharedLandmarks(state_, kOfA, kOfB).empty());
  EXPECT_TRUE(FindSharedLandmarks(state_, kOfA, {kMapB, 7}).empty());
}

TEST_F(LandmarkAgreementTest, KeyframesThatStandRightAgree) {
  SeePointsOfA();
  EXPECT_LT(Disagreement_px(kOfA, kOfB), 1e-3);
}

TEST_F(LandmarkAgreementTest, KeyframesThatDriftedApartDisagreeByWhatBothSee) {
  SeePointsOfA();
  // B's keyframe is 0.2 m aside, which is 20 px at 5 m.
  state_.global.keyframes[kOfB] = {
      Similarity3d::FromRigid({Eigen::Quaterniond::Identity(), {0.2, 0, 0}}), Rigid3d(), 1};
  EXPECT_NEAR(Disagreement_px(kOfA, kOfB), 20, 1e-3);
  EXPECT_NEAR(Disagreement_px(kOfB, kOfA), 20, 1e-3);
}

TEST_F(LandmarkAgreementTest, BehindTheCameraIsNoAgreement) {
  SeePointsOfA();
  state_.global.keyframes[kOfB] = {
      Similarity3d::FromRigid({Eigen::Quaterniond::Identity(), {0, 0, -10}}), Rigid3d(), 1};
  EXPECT_GT(Disagreement_px(kOfA, kOfB), 1e6);
}

}  // namespace
}  // namespace corbslam::map_store

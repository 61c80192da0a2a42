#include "slam/verification/frame_location.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slam/geometry/lie.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam {
namespace {

using testing::MakeRingWorld;
using testing::MakeSyntheticMap;
using testing::PosesOnRing;
using testing::SyntheticMap;
using testing::SyntheticWorld;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};

// A map of a ring, and pictures that another robot took on it.
class FrameLocationTest : public ::testing::Test {
 protected:
  FrameLocationTest()
      : world_(MakeRingWorld(3)),
        map_(MakeSyntheticMap(world_, PosesOnRing(0, 3, 12), {.local_map = kA, .seed = 5})),
        pictures_(MakeSyntheticMap(world_, PosesOnRing(13.5, 3, 12), {.local_map = kB, .seed = 6})),
        far_(MakeSyntheticMap(world_, PosesOnRing(180, 3, 4), {.local_map = kB, .seed = 7})) {}

  static Keyframe PictureOf(const SyntheticMap& pictures, uint32_t index) {
    Keyframe frame;
    const Keyframe& taken = *pictures.map.FindKeyframe({kB, index});
    frame.payload = taken.payload;
    frame.words = taken.words;
    return frame;
  }
  LocateFrameRequest RequestOf(const SyntheticMap& pictures, uint32_t index) const {
    LocateFrameRequest request;
    request.base_revision = 7;
    request.frame = PictureOf(pictures, index);
    request.view = map_.map;
    request.candidates = {{{kA, 0}, 90}, {{kA, 6}, 80}};
    return request;
  }
  // The frame of the map is that of its first camera.
  Rigid3d TrueCameraFromMap(const SyntheticMap& pictures, uint32_t index) const {
    return pictures.true_camera_from_world.at({kB, index}) *
           map_.true_camera_from_world.at({kA, 0}).Inverse();
  }

  const SyntheticWorld world_;
  const SyntheticMap map_;
  const SyntheticMap pictures_;
  const SyntheticMap far_;
};

TEST_F(FrameLocationTest, FindsWhereThePictureWasTaken) {
  const LocateFrameResult result = LocateFrame(RequestOf(pictures_, 2));
  ASSERT_EQ(ToString(result.stage), "LOCATED");
  EXPECT_EQ(result.base_revision, 7u);
  const Rigid3d error = result.camera_from_map * TrueCameraFromMap(pictures_, 2).Inverse();
  EXPECT_LT(error.translation.norm(), 0.05);
  EXPECT_LT(RotationAngle(error.rotation), 0.005);
  EXPECT_GE(result.inliers, 30);
  ASSERT_FALSE(result.keyframes.empty());
  EXPECT_LE(result.keyframes.size(), 10u);
  // At 19.5 degrees, between those of 18 and 21.
  EXPECT_NEAR(result.keyframes.front().index, 6, 2);
}

TEST_F(FrameLocationTest, SaysHowWellThePictureTells) {
  const LocateFrameResult result = LocateFrame(RequestOf(pictures_, 2));
  ASSERT_TRUE(result.covariance.has_value());
  const Rigid3d found = result.camera_from_map.Inverse();
  const Rigid3d truth = TrueCameraFromMap(pictures_, 2).Inverse();
  Vector6d error;
  error << found.translation - truth.translation,
      LogSO3(found.rotation * truth.rotation.conjugate());
  // The points have errors of their own besides the pixels'.
  EXPECT_LT(error.dot(result.covariance->inverse() * error), 100);
  const double position_variance = result.covariance->topLeftCorner<3, 3>().trace();
  EXPECT_LT(position_variance, 0.01);
}

TEST_F(FrameLocationTest, SaysNothingOfAPlaceThatIsNotInTheMap) {
  const LocateFrameResult result = LocateFrame(RequestOf(far_, 1));
  EXPECT_LT(result.stage, LocateStage::kLocated) << result.inliers;
  EXPECT_TRUE(result.keyframes.empty());
  EXPECT_FALSE(result.covariance.has_value());
  EXPECT_TRUE(result.camera_from_map.translation.isZero());
}

TEST_F(FrameLocationTest, TellsTheStageItReached) {
  LocateFrameRequest request = RequestOf(pictures_, 2);
  EXPECT_EQ(LocateFrame(request, {.min_features = 100'000}).stage, LocateStage::kFewFeatures);
  EXPECT_EQ(LocateFrame(request, {.min_word_matches = 10'000}).stage, LocateStage::kFewMatches);
  EXPECT_EQ(LocateFrame(request, {.min_pose_inliers = 10'000}).stage, LocateStage::kNoPose);
  const LocateFrameResult few = LocateFrame(request, {.min_inliers = 10'000});
  EXPECT_EQ(few.stage, LocateStage::kFewInliers);
  EXPECT_GT(few.inliers, 30);
  request.candidates.clear();
  EXPECT_EQ(LocateFrame(request).stage, LocateStage::kNoCandidates);
  request.candidates = {{{kA, 99}, 50}};
  EXPECT_EQ(LocateFrame(request).stage, LocateStage::kNoCandidates);
}

// A picture of another size, a calibration of another camera: pixels are where that has them.
TEST_F(FrameLocationTest, DoesNotBelieveAPoseOfAnotherCamera) {
  LocateFrameRequest request = RequestOf(pictures_, 2);
  Camera told = request.frame.camera();
  const double fx_px = told.fx_px;
  told.fx_px *= 1.05;
  told.fy_px *= 1.05;
  request.frame.payload = MakeKeyframePayload({}, 0, 0, std::make_shared<const Camera>(told),
                                              Features(request.frame.payload->features));
  ASSERT_EQ(ToString(LocateFrame(request, {.check_camera = false}).stage), "LOCATED");
  const LocateFrameResult result = LocateFrame(request);
  EXPECT_EQ(ToString(result.stage), "FEW_INLIERS");
  ASSERT_TRUE(result.fitting_camera.has_value());
  EXPECT_NEAR(result.fitting_camera->fx_px, fx_px, 0.02 * fx_px);
  EXPECT_FALSE(LocateFrame(RequestOf(pictures_, 2)).fitting_camera.has_value());
}

TEST_F(FrameLocationTest, EndsWhenNobodyWaits) {
  LocateFrameRequest request = RequestOf(pictures_, 2);
  int asked = 0;
  const LocateFrameResult result = LocateFrame(request, {}, [&](double) { return ++asked < 1; });
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(result.stage, LocateStage::kNoCandidates);
}

TEST_F(FrameLocationTest, IsTheSameEachTime) {
  const LocateFrameResult a = LocateFrame(RequestOf(pictures_, 4));
  const LocateFrameResult b = LocateFrame(RequestOf(pictures_, 4));
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.camera_from_map.translation, b.camera_from_map.translation);
}

}  // namespace
}  // namespace corbslam

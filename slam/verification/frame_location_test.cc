#include "slam/verification/frame_location.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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

// What is said of a camera: in shares of the true focal lengths, of the picture's sides, and what
// its lens moves (k1).
struct Said {
  double fx = 1;
  double fy = 1;
  double cx = 0;
  double cy = 0;
  double k1 = 0;
};

std::vector<Said> WrongCameras() {
  std::vector<Said> all;
  for (const double f :
       {0.34, 0.5, 0.65, 0.8, 0.9, 0.95, 0.98, 0.99, 1.01, 1.02, 1.05, 1.12, 1.3, 1.7, 2.2, 3.0}) {
    all.push_back({.fx = f, .fy = f});
  }
  for (const double f : {0.5, 0.8, 0.95, 1.05, 1.3, 2.0}) {
    all.push_back({.fx = f});
    all.push_back({.fy = f});
    all.push_back({.fx = f, .fy = 1 / f});
  }
  for (const double c : {-0.4, -0.2, -0.1, -0.03, -0.01, 0.01, 0.03, 0.1, 0.2, 0.4}) {
    all.push_back({.cx = c});
    all.push_back({.cy = c});
    all.push_back({.fx = 0.7, .fy = 0.7, .cx = c, .cy = -c});
  }
  for (const double k : {-0.3, -0.1, -0.03, 0.03, 0.1, 0.3}) {
    all.push_back({.k1 = k});
    all.push_back({.fx = 1.2, .fy = 1.2, .k1 = k});
  }
  return all;
}

// Returns the picture as somebody hands it in who says that of its camera.
Keyframe WithSaid(const Keyframe& taken, const Said& said) {
  Camera told = taken.camera();
  told.fx_px *= said.fx;
  told.fy_px *= said.fy;
  told.cx_px += said.cx * told.width_px;
  told.cy_px += said.cy * told.height_px;
  Features features = taken.payload->features;
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.disparity_px = 0;
    const Eigen::Vector2d straight = BentCamera{told, said.k1, 0}.Straighten(keypoint.Pixel());
    keypoint.x_px = static_cast<float>(straight.x());
    keypoint.y_px = static_cast<float>(straight.y());
  }
  Keyframe frame = taken;
  frame.payload =
      MakeKeyframePayload({}, 0, 0, std::make_shared<const Camera>(told), std::move(features));
  return frame;
}

// Returns by how many of its standard deviations a pose is off, in place or in rotation.
double SigmasOff(const LocateFrameResult& result, const Rigid3d& true_camera_from_map) {
  if (!result.covariance.has_value()) return std::numeric_limits<double>::infinity();
  const Rigid3d found = result.camera_from_map.Inverse();
  const Rigid3d truth = true_camera_from_map.Inverse();
  const double place = (found.translation - truth.translation).norm();
  const double turn = RotationAngle(found.rotation * truth.rotation.conjugate());
  return std::max(place / std::sqrt(result.covariance->topLeftCorner<3, 3>().trace()),
                  turn / std::sqrt(result.covariance->bottomRightCorner<3, 3>().trace()));
}

// The smaller sister of tests/accuracy/wrong_cameras.py.
TEST_F(FrameLocationTest, NoPoseIsWrongByMoreThanItSaysWhateverTheCameraIsSaidToBe) {
  int asked = 0;
  int located = 0;
  for (const Said& said : WrongCameras()) {
    for (const uint32_t index : {2u, 6u}) {
      LocateFrameRequest request = RequestOf(pictures_, index);
      request.frame = WithSaid(request.frame, said);
      const LocateFrameResult result = LocateFrame(request);
      ++asked;
      if (result.stage != LocateStage::kLocated) continue;
      ++located;
      EXPECT_LT(SigmasOff(result, TrueCameraFromMap(pictures_, index)), 5)
          << "fx " << said.fx << " fy " << said.fy << " cx " << said.cx << " cy " << said.cy
          << " k1 " << said.k1 << ", picture " << index << ", " << result.inliers << " inliers";
    }
  }
  EXPECT_GT(asked, 150);
  EXPECT_LT(located, asked / 3) << "most of these are far off, and are told";
}

TEST_F(FrameLocationTest, PicturesOfTheVeryCameraAreFound) {
  for (uint32_t index = 0; index < 7; ++index) {
    for (const uint64_t seed : {1u, 2u, 3u}) {
      LocateFrameRequest request = RequestOf(pictures_, index);
      request.frame = WithSaid(request.frame, {});
      const LocateFrameResult result = LocateFrame(request, {.seed = seed});
      ASSERT_EQ(ToString(result.stage), "LOCATED")
          << index << ": " << result.inliers << " inliers of " << result.visible_points << ", "
          << result.inliers_needed << " needed";
      EXPECT_LT(SigmasOff(result, TrueCameraFromMap(pictures_, index)), 5) << index;
    }
  }
}

TEST_F(FrameLocationTest, SaysWhatTheRuleThatAskedForMostNeeded) {
  const LocateFrameResult found = LocateFrame(RequestOf(pictures_, 2));
  EXPECT_GE(found.inliers_needed, 30);
  EXPECT_GE(found.inliers, found.inliers_needed);
  EXPECT_GT(found.visible_points, found.inliers / 2);
  const LocateFrameResult few = LocateFrame(RequestOf(pictures_, 2), {.min_inliers = 10'000});
  EXPECT_EQ(few.inliers_needed, 10'000);
  const LocateFrameResult share =
      LocateFrame(RequestOf(pictures_, 2), {.min_inliers_to_visible = 20});
  EXPECT_EQ(ToString(share.stage), "FEW_INLIERS");
  EXPECT_EQ(share.inliers_needed, 20 * share.visible_points);
}

// A wall that the camera looks at straight: with twice the focal length it would be twice as far.
TEST_F(FrameLocationTest, OfAFlatViewTheCameraIsInDoubt) {
  LocateFrameRequest request = RequestOf(pictures_, 2);
  const Rigid3d truth = TrueCameraFromMap(pictures_, 2);
  Map flat;
  for (const auto& [id, keyframe] : request.view.keyframes()) {
    Keyframe copy;
    copy.payload = keyframe.payload;
    copy.words = keyframe.words;
    copy.camera_from_map = keyframe.camera_from_map;
    flat.AddKeyframe(std::move(copy));
  }
  for (const auto& [id, point] : request.view.points()) {
    const Eigen::Vector3d x = truth * point.position_in_map;
    if (x.z() <= 0) continue;
    MapPoint moved = point;
    moved.observations.clear();
    moved.position_in_map = truth.Inverse() * Eigen::Vector3d(x * 8 / x.z());
    moved.min_distance = moved.max_distance = 0;
    moved.normal_in_map = Eigen::Vector3d::Zero();
    flat.AddPoint(moved);
    for (const auto& [keyframe, keypoint] : point.observations) {
      flat.AddObservation(id, keyframe, keypoint);
    }
  }
  request.view = flat;
  request.frame = WithSaid(request.frame, {});
  ASSERT_EQ(ToString(LocateFrame(request, {.check_camera = false}).stage), "LOCATED");
  const LocateFrameResult result = LocateFrame(request);
  EXPECT_EQ(ToString(result.stage), "CAMERA_IN_DOUBT");
  EXPECT_FALSE(result.covariance.has_value());
  EXPECT_TRUE(result.camera_from_map.translation.isZero());
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

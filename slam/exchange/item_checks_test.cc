#include "slam/exchange/item_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "slam/camera/testing/test_camera.h"

namespace corbslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr LocalMapId kMap{1};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

FullMapPoint GoodPoint() {
  FullMapPoint point;
  point.id = {kMap, 7};
  point.reference = {kMap, 0};
  point.position_in_local = {1, 2, 3};
  point.normal_in_local = {0, 0, 1};
  point.max_distance = 10;
  return point;
}

FullKeyframe KeyframeAt(float x_px) {
  Features features;
  features.keypoints.resize(2);
  features.descriptors.resize(2);
  features.keypoints[1].x_px = x_px;
  return {MakeKeyframePayload({kMap, 3}, 0, 0, testing::TestCamera(), std::move(features)), {}, {}};
}

void ExpectRefused(const absl::Status& status, const std::string& item, const std::string& field) {
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr(item), HasSubstr(field)));
}

TEST(ItemChecksTest, APointMustHaveAFinitePlace) {
  EXPECT_TRUE(ValidateFullPoint(GoodPoint()).ok());
  FullMapPoint point = GoodPoint();
  point.position_in_local.y() = kNan;
  ExpectRefused(ValidateFullPoint(point), ToString(point.id), "position is nan");
  point = GoodPoint();
  point.normal_in_local.z() = 2;
  ExpectRefused(ValidateFullPoint(point), ToString(point.id), "normal is 2");
  point = GoodPoint();
  point.min_distance = 11;
  ExpectRefused(ValidateFullPoint(point), ToString(point.id), "max_distance is 10");
}

TEST(ItemChecksTest, AKeyframeMustHaveAPoseAndKeypointsNearItsPicture) {
  const Camera& camera = *testing::TestCamera();
  EXPECT_TRUE(ValidateFullKeyframe(KeyframeAt(600), camera).ok());
  ExpectRefused(ValidateFullKeyframe(KeyframeAt(1300), camera), ToString(KeyframeId{kMap, 3}),
                "x_px of keypoint 1 is 1300");
  FullKeyframe keyframe = KeyframeAt(600);
  keyframe.camera_from_local.rotation.coeffs() *= 1.1;
  ExpectRefused(ValidateFullKeyframe(keyframe, camera), ToString(KeyframeId{kMap, 3}), "1.1");
}

TEST(ItemChecksTest, ALoopEdgeMustHaveAScale) {
  Similarity3d similarity;
  EXPECT_TRUE(ValidateSimilarity("loop edge from", {kMap, 0}, similarity).ok());
  similarity.scale = 0;
  ExpectRefused(ValidateSimilarity("loop edge from", {kMap, 0}, similarity), "loop edge",
                "scale is 0");
}

}  // namespace
}  // namespace corbslam

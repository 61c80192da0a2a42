#include "slam/camera/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam {
namespace {

using ::testing::HasSubstr;

const Camera kCamera = {.fx_px = 718.856,
                        .fy_px = 718.856,
                        .cx_px = 607.1928,
                        .cy_px = 185.2157,
                        .width_px = 1241,
                        .height_px = 376,
                        .baseline_m = 0.537,
                        .close_depth_m = 18.8};

TEST(CameraTest, AcceptsACalibrationOfAStreet) { EXPECT_TRUE(Validate(kCamera).ok()); }

TEST(CameraTest, NamesTheImpossibleField) {
  Camera camera = kCamera;
  camera.fy_px = 0;
  EXPECT_THAT(Validate(camera).message(), HasSubstr("fy_px is 0"));
  camera = kCamera;
  camera.baseline_m = -1;
  EXPECT_THAT(Validate(camera).message(), HasSubstr("baseline_m is -1"));
}

TEST(CameraTest, UnprojectInvertsProject) {
  const Eigen::Vector3d point(3.5, -1.25, 12);
  const Eigen::Vector2d pixel = Project(kCamera, point);
  EXPECT_TRUE(Unproject(kCamera, pixel.x(), pixel.y(), 12).isApprox(point, 1e-12));
}

TEST(CameraTest, DisparityAndDepthAreInverse) {
  EXPECT_NEAR(DepthFromDisparity(kCamera, DisparityFromDepth(kCamera, 7.5)), 7.5, 1e-12);
  EXPECT_NEAR(DisparityFromDepth(kCamera, 0.537), 718.856, 1e-9);
}

}  // namespace
}  // namespace corbslam

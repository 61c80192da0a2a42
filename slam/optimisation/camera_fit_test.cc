#include "slam/optimisation/camera_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "slam/geometry/lie.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

const Rigid3d kTruePose = ExpSE3((Vector6d() << 0.4, -0.2, 0.3, 0.1, -0.2, 0.15).finished());

// Points 4 to 20 m away, as `taken_by` sees them, with half a pixel of noise.
std::vector<PoseObservation> Seen(const Camera& taken_by, double radial, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> noise_px(0, 0.5);
  std::vector<PoseObservation> observations;
  for (int i = 0; i < 200; ++i) {
    const double z = 4 + 16 * uniform(random);
    const Eigen::Vector3d x = Unproject(taken_by, taken_by.width_px * uniform(random),
                                        taken_by.height_px * uniform(random), z);
    const double bent = 1 + radial * (x / z).head<2>().squaredNorm();
    const Eigen::Vector2d pixel = Project(taken_by, {bent * x.x(), bent * x.y(), z}) +
                                  Eigen::Vector2d(noise_px(random), noise_px(random));
    observations.push_back({kTruePose.Inverse() * x, pixel,
                            DisparityFromDepth(taken_by, z) + noise_px(random),
                            /*variance_px2=*/1});
  }
  return observations;
}

std::optional<CameraFit> Fit(const Camera& told, const Camera& taken_by, double radial = 0,
                             uint32_t seed = 1) {
  const std::vector<PoseObservation> seen = Seen(taken_by, radial, seed);
  return FitCamera(told, OptimisePose(told, kTruePose, seen).camera_from_map, seen);
}

TEST(CameraFitTest, TheRightCameraIsRight) {
  const Camera camera = testing::SyntheticCamera();
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const auto fit = Fit(camera, camera, 0, seed);
    ASSERT_TRUE(fit.has_value());
    EXPECT_FALSE(IsAnotherCamera(*fit)) << seed;
    EXPECT_NEAR(fit->focal.value, 0, 0.02) << seed;
  }
}

TEST(CameraFitTest, FindsTheFocalLength) {
  const Camera camera = testing::SyntheticCamera();
  for (const double share : {0.8, 0.95, 1.05, 1.25}) {
    Camera told = camera;
    told.fx_px *= share;
    told.fy_px *= share;
    const auto fit = Fit(told, camera);
    ASSERT_TRUE(fit.has_value());
    EXPECT_TRUE(IsAnotherCamera(*fit)) << share;
    EXPECT_NEAR(fit->camera.fx_px, camera.fx_px, 0.02 * camera.fx_px) << share;
    EXPECT_LT((fit->camera_from_map * kTruePose.Inverse()).translation.norm(), 0.2) << share;
  }
}

TEST(CameraFitTest, FindsWhatElseIsAnothers) {
  const Camera camera = testing::SyntheticCamera();
  Camera cropped = camera;
  cropped.cx_px += 0.1 * camera.width_px;
  EXPECT_TRUE(IsAnotherCamera(*Fit(cropped, camera)));
  Camera squeezed = camera;
  squeezed.fy_px *= 1.1;
  EXPECT_TRUE(IsAnotherCamera(*Fit(squeezed, camera)));
  EXPECT_TRUE(IsAnotherCamera(*Fit(camera, camera, 0.3))) << "its distortion was forgotten";
  Camera apart = camera;
  apart.baseline_m *= 1.2;
  const auto fit = Fit(apart, camera);
  EXPECT_TRUE(IsAnotherCamera(*fit));
  EXPECT_NEAR(fit->camera.baseline_m, camera.baseline_m, 0.03 * camera.baseline_m);
}

TEST(BentCameraTest, WhatALensBentIsStraightened) {
  const Camera camera = testing::SyntheticCamera();
  for (const BentCamera& bent :
       {BentCamera{.camera = camera, .k1 = -0.1, .k2 = 0.02},
        BentCamera{.camera = camera, .p1 = 0.03, .p2 = -0.02},
        BentCamera{.camera = camera, .k1 = 0.1, .p1 = -0.02, .p2 = 0.04}}) {
    for (const Eigen::Vector3d& x : {Eigen::Vector3d(0, 0, 4), Eigen::Vector3d(1, 0.5, 4),
                                     Eigen::Vector3d(-1.2, 0.9, 4), Eigen::Vector3d(0.1, -1, 4)}) {
      const Eigen::Vector2d straight = bent.Straighten(bent.Project(x));
      EXPECT_LT((straight - Project(camera, x)).norm(), 0.1) << bent.p1 << ", " << x.transpose();
    }
  }
}

// A picture that was padded, and whose lens was undone as if it had not been.
TEST(CameraFitTest, ALensThatWasUndoneAboutAnotherCentreIsNoticed) {
  const Camera camera = testing::SyntheticCamera();
  const BentCamera lens = {.camera = camera, .k1 = -0.25, .k2 = 0.05};
  for (const double share : {0.01, 0.02, 0.04, 0.06, 0.08, 0.12, 0.16}) {
    const Eigen::Vector2d padding(share * camera.width_px, share * camera.height_px);
    std::vector<PoseObservation> seen = Seen(camera, 0, 3);
    for (PoseObservation& o : seen) {
      const Eigen::Vector3d x = kTruePose * o.x_in_map;
      const Eigen::Vector2d noise_px = o.pixel - Project(camera, x);
      o.pixel = lens.Straighten(lens.Project(x) + noise_px + padding);
    }
    const Rigid3d found = OptimisePose(camera, kTruePose, seen).camera_from_map;
    const auto fit = FitCamera(camera, found, seen);
    ASSERT_TRUE(fit.has_value());
    const Matrix6d covariance = CovarianceOfAnyCamera(*fit, found);
    const double off_rad = LogSE3(found * kTruePose.Inverse()).tail<3>().norm();
    const double sigma_rad = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
    EXPECT_TRUE(IsAnotherCamera(*fit) || off_rad < 5 * sigma_rad)
        << share << ": " << off_rad << " rad off, sigma " << sigma_rad;
    EXPECT_TRUE(IsAnotherCamera(*fit) || share < 0.08) << share;
  }
}

TEST(CameraFitTest, SaysNothingOfWhatThePointsDoNotTell) {
  const Camera camera = testing::SyntheticCamera();
  std::vector<PoseObservation> seen = Seen(camera, 0, 1);
  seen.resize(10);
  EXPECT_FALSE(FitCamera(camera, kTruePose, seen).has_value());
  // A wall that the camera looks at: whether it is near or the focal length long can't be told.
  seen = Seen(camera, 0, 1);
  for (PoseObservation& o : seen) {
    const Eigen::Vector3d x = kTruePose * o.x_in_map;
    o.x_in_map = kTruePose.Inverse() * Eigen::Vector3d(x * 10 / x.z());
    o.disparity_px = 0;
  }
  Camera told = camera;
  told.fx_px *= 1.2;
  told.fy_px *= 1.2;
  const auto fit = FitCamera(told, OptimisePose(told, kTruePose, seen).camera_from_map, seen);
  if (fit.has_value()) {
    EXPECT_FALSE(IsAnotherCamera(*fit)) << fit->focal.sigma;
  }
}

}  // namespace
}  // namespace corbslam

#include "client_agent/tracking/camera_doubt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "client_agent/tracking/frame_evidence.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

// A frame and the points of others around it.
struct Found {
  Frame frame;
  std::vector<PointInView> points;
};

// Returns a frame tracked with the camera that is said, of 300 points 4 to 20 m away, of a picture
// that another camera took. It is associated with what agrees, as tracking associates it.
Found Track(const Camera& said, const Camera& taken_by, uint32_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> noise_px(0, 0.4);
  Found found;
  Features features;
  std::vector<Association> associations;
  for (uint32_t i = 0; i < 300; ++i) {
    const double z = 4 + 16 * uniform(random);
    const Eigen::Vector2d pixel(taken_by.width_px * uniform(random),
                                taken_by.height_px * uniform(random));
    Keypoint& keypoint = features.keypoints.emplace_back();
    keypoint.x_px = static_cast<float>(pixel.x() + noise_px(random));
    keypoint.y_px = static_cast<float>(pixel.y() + noise_px(random));
    Descriptor& descriptor = features.descriptors.emplace_back();
    for (auto& word : descriptor.words) word = random();
    MatchPoint& point = found.points.emplace_back().point;
    point.id = MapPointId{{2}, i};
    point.position_in_map = Unproject(taken_by, pixel.x(), pixel.y(), z);
    point.descriptor = descriptor;
    associations.push_back({Association::Kind::kMapPoint, point.id, point.position_in_map});
  }
  found.frame =
      MakeFrame({.camera = std::make_shared<Camera>(said), .features = std::move(features)});
  found.frame.associations = std::move(associations);
  OptimiseFramePose(Rigid3d::Identity(), LocalMapId{1}, found.frame);
  return found;
}

Camera WithFocal(const Camera& camera, double share) {
  Camera said = camera;
  said.fx_px *= share;
  said.fy_px *= share;
  return said;
}

bool BelievesFound(const Camera& said, const Camera& taken_by, uint32_t seed) {
  CameraDoubt doubt;
  const Found found = Track(said, taken_by, seed);
  return doubt.BelievesFound(found.frame, found.points);
}

TEST(CameraDoubtTest, TheRigsOwnCameraIsBelieved) {
  const Camera camera = testing::SyntheticCamera();
  CameraDoubt doubt;
  for (uint32_t seed = 0; seed < 20; ++seed) {
    const Found found = Track(camera, camera, seed);
    EXPECT_TRUE(doubt.BelievesFound(found.frame, found.points)) << seed;
  }
  EXPECT_FALSE(doubt.has_warned());
}

// What is far off has few points that agree, which then seem to fit.
TEST(CameraDoubtTest, AnotherCameraIsNotHoweverFarOffItIs) {
  const Camera camera = testing::SyntheticCamera();
  for (const double share : {0.35, 0.5, 0.7, 0.9, 0.94, 1.06, 1.15, 1.5, 2.0, 3.0}) {
    EXPECT_FALSE(BelievesFound(WithFocal(camera, share), camera, 1)) << share;
  }
  for (const double share : {-0.3, -0.1, 0.1, 0.3}) {
    Camera said = camera;
    said.cx_px += share * said.width_px;
    EXPECT_FALSE(BelievesFound(said, camera, 2)) << share;
  }
}

TEST(CameraDoubtTest, WarnsAfterTwoLooksAndGivesNoPoseFromThere) {
  const Camera camera = testing::SyntheticCamera();
  CameraDoubt doubt;
  const Found good = Track(camera, camera, 1);
  const Found bad = Track(WithFocal(camera, 1.1), camera, 1);
  ASSERT_TRUE(doubt.BelievesFound(good.frame, good.points));
  int believed = 0;
  while (doubt.BelievesTracked(bad.frame, bad.points)) ++believed;
  EXPECT_EQ(believed, 2 * CameraDoubt::kEachFrames - 1);
  EXPECT_TRUE(doubt.has_warned());
}

// A few per cent of the focal length are not beyond doubt: then the covariance says so.
TEST(CameraDoubtTest, WhatIsLetPassIsInTheCovariance) {
  const Camera camera = testing::SyntheticCamera();
  for (const double share : {0.97, 0.98, 0.99, 1.01, 1.02, 1.03}) {
    const Found found = Track(WithFocal(camera, share), camera, 3);
    const auto covariance = AnyCamerasCovariance(found.frame);
    ASSERT_TRUE(covariance.has_value());
    const double off = CameraCentre(found.frame.camera_from_map).norm();
    EXPECT_LT(off, 3 * std::sqrt(covariance->topLeftCorner<3, 3>().trace())) << share;
  }
}

}  // namespace
}  // namespace corbslam::client_agent

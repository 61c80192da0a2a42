#include "client_agent/tracking/camera_doubt.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

// Returns a frame tracked with the camera that is said, of 300 points 4 to 20 m away, of a picture
// that another camera took.
Frame TrackedFrame(const Camera& said, const Camera& taken_by, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> noise_px(0, 0.4);
  Features features;
  std::vector<Association> associations;
  for (uint32_t i = 0; i < 300; ++i) {
    const double z = 4 + 16 * uniform(random);
    const Eigen::Vector2d pixel(taken_by.width_px * uniform(random),
                                taken_by.height_px * uniform(random));
    Keypoint& keypoint = features.keypoints.emplace_back();
    keypoint.x_px = static_cast<float>(pixel.x() + noise_px(random));
    keypoint.y_px = static_cast<float>(pixel.y() + noise_px(random));
    keypoint.disparity_px = static_cast<float>(DisparityFromDepth(taken_by, z) + noise_px(random));
    associations.push_back({Association::Kind::kMapPoint, MapPointId{{2}, i},
                            Unproject(taken_by, pixel.x(), pixel.y(), z)});
  }
  features.descriptors.resize(features.keypoints.size());
  Frame frame = MakeFrame(0, std::make_shared<Camera>(said), std::move(features));
  frame.associations = std::move(associations);
  OptimiseFramePose(Rigid3d::Identity(), LocalMapId{1}, frame);
  return frame;
}

bool Warns(const Camera& said, const Camera& taken_by, int frames) {
  CameraDoubt doubt;
  for (int i = 0; i < frames; ++i) {
    const bool is_looked_at = i % CameraDoubt::kEachFrames == CameraDoubt::kEachFrames - 1;
    doubt.Look(is_looked_at ? TrackedFrame(said, taken_by, static_cast<uint32_t>(i)) : Frame());
  }
  return doubt.has_warned();
}

constexpr int kEnough = CameraDoubt::kEachFrames * CameraDoubt::kEnough;

TEST(CameraDoubtTest, TheRigsOwnCameraIsNotDoubted) {
  const Camera camera = testing::SyntheticCamera();
  EXPECT_FALSE(Warns(camera, camera, 4 * kEnough));
}

TEST(CameraDoubtTest, AnotherFocalLengthOrCentreIs) {
  const Camera camera = testing::SyntheticCamera();
  for (const double share : {0.95, 1.05}) {
    Camera said = camera;
    said.fx_px *= share;
    said.fy_px *= share;
    EXPECT_TRUE(Warns(said, camera, kEnough)) << share;
    EXPECT_FALSE(Warns(said, camera, kEnough - 1)) << "one picture proves little";
  }
}

}  // namespace
}  // namespace corbslam::client_agent

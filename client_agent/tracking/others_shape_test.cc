// Tests OthersShape on frames of a camera that drives along a street of points.
#include "client_agent/tracking/others_shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "slam/camera/testing/test_camera.h"

namespace corbslam::client_agent {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr LocalMapId kOwnMap{1};
constexpr LocalMapId kOthersMap{2};
constexpr double kWayOfFrame_m = 0.5;
constexpr double kRadian = std::numbers::pi / 180;

Eigen::Vector3d AsItIs(const Eigen::Vector3d& x) { return x; }

// Turns what lies beyond `z_m` about the vertical there.
Eigen::Vector3d Turned(const Eigen::Vector3d& x, double z_m, double angle_rad) {
  if (x.z() < z_m) return x;
  const Eigen::Vector3d pivot(0, 0, z_m);
  return pivot + Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()) * (x - pivot);
}

class OthersShapeTest : public ::testing::Test {
 protected:
  // Where the other's map has a point of the world.
  using Bend = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

  OthersShapeTest() {
    std::uniform_real_distribution<double> side_m(-12, 12);
    std::uniform_real_distribution<double> height_m(-3, 3);
    std::uniform_real_distribution<double> along_m(0, 260);
    for (int i = 0; i < 3000; ++i) {
      world_.emplace_back(side_m(random_), height_m(random_), along_m(random_));
    }
  }

  // What the camera sees of the world from there, tracked in the map.
  Frame See(double z_m, const Bend& bend, LocalMapId local_map) {
    std::normal_distribution<float> noise_px(0, 0.3F);
    Features features;
    std::vector<Association> associations;
    for (size_t i = 0; i < world_.size(); ++i) {
      const Eigen::Vector3d x = world_[i] - Eigen::Vector3d(0, 0, z_m);
      if (x.z() < 4 || x.z() > 40) continue;
      const double u = camera_.fx_px * x.x() / x.z() + camera_.cx_px;
      const double v = camera_.fy_px * x.y() / x.z() + camera_.cy_px;
      if (u < 0 || v < 0 || u >= camera_.width_px || v >= camera_.height_px) continue;
      Keypoint keypoint;
      keypoint.x_px = static_cast<float>(u) + noise_px(random_);
      keypoint.y_px = static_cast<float>(v) + noise_px(random_);
      keypoint.disparity_px =
          static_cast<float>(camera_.fx_px * camera_.baseline_m / x.z()) + noise_px(random_);
      features.keypoints.push_back(keypoint);
      const MapPointId id{local_map, static_cast<uint32_t>(i)};
      associations.push_back({Association::Kind::kMapPoint, id, bend(world_[i])});
    }
    features.descriptors.resize(features.keypoints.size());
    Frame frame =
        MakeFrame({.camera = std::make_shared<Camera>(camera_), .features = std::move(features)});
    frame.associations = std::move(associations);
    const Rigid3d near{Eigen::Quaterniond::Identity(), -bend({0, 0, z_m})};
    OptimiseFramePose(near, kOwnMap, frame);
    return frame;
  }
  // Drives from 0 to 200 m; returns what is told on the way.
  std::vector<MapContradiction> Drive(const Bend& bend, LocalMapId local_map = kOthersMap) {
    std::vector<MapContradiction> told;
    for (double z_m = 0; z_m < 200; z_m += kWayOfFrame_m) {
      const auto found = shape_.Add(See(z_m, bend, local_map), kOwnMap);
      if (found.has_value()) told.push_back(*found);
    }
    return told;
  }

  Camera camera_ = testing::CarCamera();
  std::mt19937 random_{7};
  std::vector<Eigen::Vector3d> world_;
  OthersShape shape_;
};

TEST_F(OthersShapeTest, TellsOnceThatAMapIsTornAndByHowMuch) {
  const std::vector<MapContradiction> told = Drive([](const Eigen::Vector3d& x) {
    return Turned(Turned(x, 140, 2 * kRadian), 80, -1.5 * kRadian);
  });
  ASSERT_THAT(told, SizeIs(1));
  EXPECT_EQ(told[0].local_map, kOthersMap);
  EXPECT_EQ(told[0].scale, 1);
  ASSERT_TRUE(told[0].bend.has_value());
  EXPECT_GT(told[0].bend->turn_rad, 0.4 * kRadian);
  EXPECT_LT(told[0].bend->turn_rad, 1.7 * kRadian);
  EXPECT_LE(told[0].bend->way_m, 8 * 5 * kWayOfFrame_m + 0.1);
}

TEST_F(OthersShapeTest, ARightMapIsNotBent) { EXPECT_THAT(Drive(AsItIs), IsEmpty()); }

TEST_F(OthersShapeTest, ASizeIsNotAShape) {
  for (const double scale : {0.94, 0.99, 1.02, 1.06}) {
    shape_ = OthersShape();
    EXPECT_THAT(Drive([scale](const Eigen::Vector3d& x) { return scale * x; }), IsEmpty()) << scale;
  }
}

TEST_F(OthersShapeTest, ALittleOverALongWayIsAsMuchAsOnesOwnDrift) {
  EXPECT_THAT(Drive([](const Eigen::Vector3d& x) {
                // A circle of 5 km: 0.01 degrees a metre.
                return Eigen::Vector3d(x.x() + x.z() * x.z() / 1e4, x.y(), x.z());
              }),
              IsEmpty());
}

TEST_F(OthersShapeTest, AMapThatIsPutRightMeanwhileIsNotTorn) {
  int frames = 0;
  for (double z_m = 0; z_m < 100; z_m += kWayOfFrame_m) {
    const double angle_rad = (frames++ / 10) * 0.02;
    EXPECT_FALSE(shape_
                     .Add(See(
                              z_m,
                              [&](const Eigen::Vector3d& x) {
                                return Turned(x + Eigen::Vector3d(0, 0, 10), 0, angle_rad);
                              },
                              kOthersMap),
                          kOwnMap)
                     .has_value())
        << z_m;
  }
}

TEST_F(OthersShapeTest, TheOwnMapAndCamerasWithoutDistancesAreNotJudged) {
  const auto torn = [](const Eigen::Vector3d& x) { return Turned(x, 80, 1.5 * kRadian); };
  EXPECT_THAT(Drive(torn, kOwnMap), IsEmpty());
  camera_.baseline_m = 0;
  EXPECT_THAT(Drive(torn), IsEmpty());
}

}  // namespace
}  // namespace corbslam::client_agent

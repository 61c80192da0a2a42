#include "slam/inertial/imu_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "slam/geometry/lie.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

// Rates of a camera that turns about all axes, and what an IMU makes of them that is wrong by a
// matrix.
ImuAxes Turning(const Eigen::Matrix3d& imu_from_camera, double noise_rps = 0.01,
                double second_axes = 1) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  ImuAxes axes;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d turning =
        0.5 * draw().cwiseProduct(Eigen::Vector3d(1, second_axes, second_axes));
    axes.Add(turning, imu_from_camera * turning + noise_rps * draw() + Eigen::Vector3d(0.02, 0, 0));
  }
  return axes;
}

TEST(ImuAxesTest, NothingIsWrongWithTheRightCalibration) {
  const auto fit = Turning(Eigen::Matrix3d::Identity()).Fit();
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(fit->left_over_as_calibrated, 0.1);
  EXPECT_NEAR(fit->scale, 1, 0.01);
  EXPECT_EQ(ImuAxes::Describe(*fit), std::nullopt);
}

TEST(ImuAxesTest, NamesTheTurnBetweenAxes) {
  const auto fit = Turning(ExpSO3({0, 0, M_PI / 2}).toRotationMatrix()).Fit();
  ASSERT_TRUE(fit.has_value());
  EXPECT_THAT(ImuAxes::Describe(*fit).value_or(""),
              HasSubstr("turned by 90 degrees about (0.00, 0.00, -1.00)"));
}

TEST(ImuAxesTest, NamesDegrees) {
  const auto fit = Turning(Eigen::Matrix3d::Identity() * (180 / M_PI), 0.5).Fit();
  ASSERT_TRUE(fit.has_value());
  EXPECT_THAT(ImuAxes::Describe(*fit).value_or(""), HasSubstr("in degrees a second?"));
}

TEST(ImuAxesTest, NamesAnotherScale) {
  const auto fit = Turning(Eigen::Matrix3d::Identity() * 2).Fit();
  ASSERT_TRUE(fit.has_value());
  EXPECT_THAT(ImuAxes::Describe(*fit).value_or(""), HasSubstr("turns 2 times as fast"));
}

TEST(ImuAxesTest, MirroredAxesAreNoTurn) {
  const Eigen::Matrix3d mirrored = Eigen::Vector3d(1, 1, -1).asDiagonal();
  const auto fit = Turning(mirrored).Fit();
  ASSERT_TRUE(fit.has_value());
  EXPECT_GT(fit->left_over, 0.3);
  EXPECT_TRUE(ImuAxes::Describe(*fit).has_value());
}

TEST(ImuAxesTest, SaysNothingOfWhatTurnsTooLittle) {
  EXPECT_FALSE(Turning(Eigen::Matrix3d::Identity(), 0.01, 0.01).Fit().has_value());
  EXPECT_FALSE(ImuAxes().Fit().has_value());
}

TEST(ImuAxesTest, AnImuThatHasNothingToDoWithTheCameraIsSaid) {
  const auto fit = Turning(Eigen::Matrix3d::Zero(), 0.5).Fit();
  ASSERT_TRUE(fit.has_value());
  EXPECT_THAT(ImuAxes::Describe(*fit).value_or(""), HasSubstr("whatever its axes are"));
}

}  // namespace
}  // namespace corbslam

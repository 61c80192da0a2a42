#include "slam/inertial/inertial_filter.h"

#include <gtest/gtest.h>

#include <random>

#include "slam/inertial/imu_buffer.h"
#include "slam/inertial/testing/felt_path.h"

namespace corbslam {
namespace {

constexpr int64_t kFlightFrame_ns = 50'000'000;
const ImuNoise kFlightNoise{1.7e-4, 2e-3, 1.9e-5, 3e-3};
const ImuBiases kFlightBiases{{0.02, -0.01, 0.03}, {0.05, 0.1, -0.08}};

// The odometry frame is turned against the world, so that nobody knows where down is.
const Rigid3d kOdomFromWorld{ExpSO3({0.6, -0.3, 1.1}), {5, -2, 1}};

// Filters a flight whose poses are seen with the noise that is said.
class Flight {
 public:
  explicit Flight(ImuPath path, uint64_t seed = 1) : path_(std::move(path)), random_(seed) {
    buffer_.Add(
        FeltAlong(path_, -100'000'000, 60'000'000'000, 200, kFlightNoise, kFlightBiases, seed));
  }

  Rigid3d Truth(int64_t time_ns) const { return kOdomFromWorld * PathAt(path_, time_ns); }

  SeenPose See(int64_t time_ns) {
    SeenPose seen{Truth(time_ns), Matrix6d::Identity()};
    seen.covariance.topLeftCorner<3, 3>() *= kPosition_m * kPosition_m;
    seen.covariance.bottomRightCorner<3, 3>() *= kTurn_rad * kTurn_rad;
    seen.odom_from_imu.translation += kPosition_m * Draw();
    seen.odom_from_imu.rotation = seen.odom_from_imu.rotation * ExpSO3(kTurn_rad * Draw());
    return seen;
  }

  InertialFilter Run(int64_t until_ns) {
    const std::vector<ImuStep> first = buffer_.Between(-50'000'000, 0);
    InertialFilter filter(kFlightNoise, See(0), first.front().mean.specific_force_mps2);
    for (int64_t now_ns = kFlightFrame_ns; now_ns <= until_ns; now_ns += kFlightFrame_ns) {
      Propagate(now_ns - kFlightFrame_ns, now_ns, filter);
      distances_.push_back(filter.Update(See(now_ns)));
    }
    return filter;
  }

  void Propagate(int64_t from_ns, int64_t to_ns, InertialFilter& filter) const {
    for (const ImuStep& step : buffer_.Between(from_ns, to_ns)) {
      filter.Propagate(step.mean, step.duration_s);
    }
  }

  const std::vector<double>& distances() const { return distances_; }

 private:
  static constexpr double kPosition_m = 0.004;
  static constexpr double kTurn_rad = 0.002;

  Eigen::Vector3d Draw() { return {normal_(random_), normal_(random_), normal_(random_)}; }

  const ImuPath path_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  ImuBuffer buffer_;
  std::vector<double> distances_;
};

Eigen::Vector3d TrueDown() { return kOdomFromWorld.rotation * Eigen::Vector3d(0, 0, -1); }

double DownError_deg(const InertialFilter& filter) {
  return 180 / M_PI * std::acos(std::min(1.0, filter.gravity_mps2().normalized().dot(TrueDown())));
}

TEST(InertialFilterTest, FindsDownAndBiasesInFlight) {
  Flight flight(FlownPath);
  const InertialFilter filter = flight.Run(10'000'000'000);
  EXPECT_LT(DownError_deg(filter), 0.3);
  EXPECT_LT((filter.biases().gyro_rps - kFlightBiases.gyro_rps).norm(), 0.002);
  EXPECT_LT((filter.biases().accel_mps2 - kFlightBiases.accel_mps2).norm(), 0.04);
  EXPECT_NEAR(filter.late_s(), 0, 0.001);
  const Rigid3d before = flight.Truth(9'999'900'000);
  const Rigid3d after = flight.Truth(10'000'100'000);
  const Eigen::Vector3d velocity = (after.translation - before.translation) / 2e-4;
  EXPECT_LT((filter.velocity_mps() - velocity).norm(), 0.03);
}

TEST(InertialFilterTest, KnowsDownWithinADegreeAfterFiveSeconds) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Flight flight(FlownPath, seed);
    EXPECT_LT(DownError_deg(flight.Run(5'000'000'000)), 1) << seed;
  }
}

TEST(InertialFilterTest, WhatItExpectsIsAsFarOffAsItSays) {
  Flight flight(FlownPath);
  flight.Run(40'000'000'000);
  double sum = 0;
  for (const double distance : flight.distances()) sum += distance;
  // Six degrees of freedom.
  EXPECT_NEAR(sum / static_cast<double>(flight.distances().size()), 6, 0.8);
}

TEST(InertialFilterTest, AfterThreeSecondsWithoutPicturesTheErrorIsWithinItsSigmas) {
  int inside = 0;
  int all = 0;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    Flight flight(FlownPath, seed);
    InertialFilter filter = flight.Run(12'000'000'000);
    flight.Propagate(12'000'000'000, 15'000'000'000, filter);
    const Eigen::Vector3d error =
        filter.odom_from_imu().translation - flight.Truth(15'000'000'000).translation;
    EXPECT_LT(error.norm(), 0.5) << seed;
    for (int i = 0; i < 3; ++i) {
      const int at = InertialFilter::kPosition + i;
      const double sigma = std::sqrt(filter.covariance()(at, at));
      EXPECT_LT(sigma, 0.3);
      inside += std::abs(error(i)) < 3 * sigma ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GE(inside, 0.95 * all);
}

TEST(InertialFilterTest, FindsHowLateSamplesAre) {
  Flight flight(FlownPath);
  // Each picture is of 4 ms before what the samples of its time are of: these are late.
  InertialFilter filter = flight.Run(50'000'000);
  for (int64_t now_ns = 2 * kFlightFrame_ns; now_ns < 30'000'000'000; now_ns += kFlightFrame_ns) {
    flight.Propagate(now_ns - kFlightFrame_ns, now_ns, filter);
    filter.Update(flight.See(now_ns - 4'000'000));
  }
  EXPECT_NEAR(filter.late_s(), 0.004, 0.001);
}

TEST(InertialFilterTest, AWrongPoseWeighsLittle) {
  Flight flight(FlownPath);
  InertialFilter filter = flight.Run(10'000'000'000);
  const Eigen::Vector3d down = filter.gravity_mps2();
  flight.Propagate(10'000'000'000, 10'050'000'000, filter);
  SeenPose wrong = flight.See(10'050'000'000);
  wrong.odom_from_imu.translation.x() += 1;
  EXPECT_GT(filter.Update(wrong), 1000);
  EXPECT_LT((filter.gravity_mps2() - down).norm(), 0.05);
  EXPECT_LT((filter.odom_from_imu().translation - flight.Truth(10'050'000'000).translation).norm(),
            0.05);
}

TEST(InertialFilterTest, WhatStandsStaysPut) {
  Flight flight([](double) { return Rigid3d(); });
  InertialFilter filter = flight.Run(5'000'000'000);
  for (int64_t now_ns = 5'000'000'000; now_ns < 15'000'000'000; now_ns += kFlightFrame_ns) {
    flight.Propagate(now_ns, now_ns + kFlightFrame_ns, filter);
    filter.UpdateStill();
  }
  EXPECT_LT((filter.odom_from_imu().translation - flight.Truth(0).translation).norm(), 0.02);
}

TEST(InertialFilterTest, AnAnchoredPoseIsKnownAndDownIsAsUncertainAsBefore) {
  Flight flight(FlownPath);
  InertialFilter filter = flight.Run(5'000'000'000);
  flight.Propagate(5'000'000'000, 8'000'000'000, filter);
  const auto spread_of = [&](int block) {
    return filter.covariance().block<3, 3>(block, block).trace();
  };
  const double turn = spread_of(InertialFilter::kTurn);
  const double gravity = spread_of(InertialFilter::kGravity);
  const double position = spread_of(InertialFilter::kPosition);
  EXPECT_GT(position, 0);
  filter.Anchor();
  EXPECT_EQ(spread_of(InertialFilter::kTurn), 0);
  EXPECT_EQ(spread_of(InertialFilter::kPosition), 0);
  // The trace over two axes across gravity, at most: turns about it say nothing of it.
  EXPECT_GT(spread_of(InertialFilter::kGravity), gravity);
  EXPECT_LT(spread_of(InertialFilter::kGravity),
            gravity + 1.01 * turn * kGravity_mps2 * kGravity_mps2);
}

}  // namespace
}  // namespace corbslam

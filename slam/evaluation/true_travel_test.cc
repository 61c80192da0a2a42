#include "slam/evaluation/true_travel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "slam/evaluation/trajectory_error.h"

namespace corbslam {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

// The path is 300 m straight, a lap of 400 m, 300 m straight.
Eigen::Vector3d At(double travel_m) {
  if (travel_m <= 300) return {travel_m, 0, 0};
  if (travel_m > 700) return {travel_m - 400, 0, 0};
  const double angle = 2 * std::numbers::pi * (travel_m - 300) / 400;
  const double radius_m = 200 / std::numbers::pi;
  return {300 + radius_m * std::sin(angle), radius_m * (1 - std::cos(angle)), 0};
}

// Makes poses at 10 m/s, `rate_hz` of them a second, each off by up to `noise_m` in every
// direction.
Trajectory MakeTruth(double rate_hz, double noise_m = 0) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 1);
  Trajectory truth;
  for (int i = 0; i <= static_cast<int>(100 * rate_hz); ++i) {
    const double time_s = i / rate_hz;
    Eigen::Vector3d position = At(10 * time_s);
    for (int axis = 0; axis < 3; ++axis) position[axis] += noise_m * noise(random);
    truth.push_back(
        {std::llround(time_s * kSecond_ns), {Eigen::Quaterniond::Identity(), position}});
  }
  return truth;
}

// Frames at 10 Hz that rise 1 cm a metre of travel, so that the error is 1 % of the travel between
// any two; those between two lengths of travel are lost.
Trajectory MakeEstimate(double lost_from_m, double lost_to_m, int stride = 1) {
  Trajectory estimate;
  for (int i = 0; i <= 1000; i += stride) {
    if (i > lost_from_m && i <= lost_to_m) continue;
    estimate.push_back({i * kSecond_ns / 10,
                        {Eigen::Quaterniond::Identity(), At(i) + Eigen::Vector3d(0, 0, 0.01 * i)}});
  }
  return estimate;
}

double TRel(const Trajectory& estimate, const Trajectory& truth) {
  const auto error = ComputeRelativeError(AssociateByTime(estimate, truth), truth);
  return error.has_value() ? error->translation_percent : -1;
}

TEST(TrueTravelTest, IsOfTheWholePathOverLostFrames) {
  const Trajectory truth = MakeTruth(10);
  const TrueTravel travel = MeasureTravel(AssociateByTime(MakeEstimate(300, 700), truth), truth);
  ASSERT_EQ(travel.at_m.size(), 601u);
  EXPECT_NEAR(travel.at_m[300], 300, 1e-6);
  EXPECT_NEAR(travel.before_m[301], 700, 0.02);
  EXPECT_NEAR(travel.at_m[301], 701, 0.02);
  EXPECT_NEAR(travel.at_m.back(), 1000, 0.02);
}

TEST(TrueTravelTest, IsThatOfThePairsWhereNoneIsLost) {
  const Trajectory dense = MakeTruth(100, 0.02);
  const std::vector<PosePair> pairs = AssociateByTime(MakeEstimate(0, 0), dense);
  EXPECT_EQ(MeasureTravel(pairs, dense).at_m, MeasureTravel(pairs, {}).at_m);
}

TEST(TrueTravelTest, DenseNoiseDoesNotCountAsTravel) {
  const Trajectory dense = MakeTruth(100, 0.02);
  EXPECT_GT(PathLength_m(dense), 1050);
  const TrueTravel travel = MeasureTravel(AssociateByTime(MakeEstimate(300, 700), dense), dense);
  EXPECT_NEAR(travel.at_m.back(), 1000, 2);
}

TEST(TrueTravelTest, HasNoTravelWithoutPairs) {
  EXPECT_TRUE(MeasureTravel({}, MakeTruth(10)).at_m.empty());
  const PosePair pair;
  // All pairs have one time, as pairs without times do.
  EXPECT_EQ(MeasureTravel({pair, pair}, MakeTruth(10)).at_m, (std::vector<double>{0, 0}));
}

struct Loss {
  const char* name;
  double from_m;
  double to_m;
  double truth_rate_hz;
  int stride;
};

class RelativeErrorOverLossTest : public ::testing::TestWithParam<Loss> {};

TEST_P(RelativeErrorOverLossTest, IsThatOfTheTrueTravel) {
  const Loss& loss = GetParam();
  const double t_rel_percent =
      TRel(MakeEstimate(loss.from_m, loss.to_m, loss.stride), MakeTruth(loss.truth_rate_hz));
  EXPECT_GE(t_rel_percent, 0.9999);
  // A segment ends with the first pose beyond its length, by up to one step: 1 m or 5 m of 100.
  EXPECT_LE(t_rel_percent, loss.truth_rate_hz < 10 || loss.stride > 1 ? 1.02 : 1.01);
}

INSTANTIATE_TEST_SUITE_P(
    AllLosses, RelativeErrorOverLossTest,
    ::testing::Values(Loss{"Nothing", 0, 0, 10, 1}, Loss{"TheLap", 300, 700, 10, 1},
                      Loss{"TheLapOfADenseTruth", 300, 700, 100, 1},
                      Loss{"HalfTheLap", 300, 500, 10, 1}, Loss{"ACorner", 380, 410, 10, 1},
                      Loss{"EachSecondFrame", 0, 0, 10, 2}, Loss{"FourOfFiveFrames", 0, 0, 10, 5},
                      Loss{"TheLapOfEachSecondFrame", 300, 700, 10, 2},
                      Loss{"TheBegin", 0, 350, 10, 1}, Loss{"TheEnd", 650, 1000, 10, 1},
                      Loss{"TheLapOfASparseTruth", 300, 700, 2, 1}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace corbslam

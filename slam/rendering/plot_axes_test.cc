#include "slam/rendering/plot_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "slam/rendering/plot_parts.h"

namespace corbslam {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(RoundTicksTest, AreRound) {
  EXPECT_THAT(RoundTicks({0, 10}, 6).values, ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(RoundTicks({0, 1}, 6).values,
              ElementsAre(DoubleEq(0), DoubleEq(0.2), DoubleEq(0.4), DoubleEq(0.6000000000000001),
                          DoubleEq(0.8), DoubleEq(1)));
  EXPECT_THAT(RoundTicks({-7, 7}, 4).values, ElementsAre(-5, 0, 5));
  EXPECT_EQ(RoundTicks({0, 0.0103}, 6).step, 0.005);
}

TEST(RoundTicksTest, StayWithinAnyRange) {
  for (const double size : {1e-9, 3e-5, 0.7, 12.0, 99.0, 1e5, 1e15}) {
    for (const double low : {0.0, -0.3 * size, 2.5 * size}) {
      const Range range{low, low + size};
      const Ticks ticks = RoundTicks(range, 6);
      EXPECT_GE(ticks.values.size(), 1u) << low << " " << size;
      EXPECT_LE(ticks.values.size(), 6u) << low << " " << size;
      for (const double value : ticks.values) {
        EXPECT_GE(value, low - 1e-6 * size);
        EXPECT_LE(value, low + size * (1 + 1e-6));
      }
    }
  }
}

TEST(FormatTickTest, HasTheDecimalsOfItsStep) {
  EXPECT_EQ(FormatTick(0.6000000000000001, 0.2), "0.6");
  EXPECT_EQ(FormatTick(0.005, 0.005), "0.005");
  EXPECT_EQ(FormatTick(50, 10), "50");
  EXPECT_EQ(FormatTick(2e9, 1e9), "2e+09");
}

TEST(RangeOfTest, IsNeverEmpty) {
  for (const std::vector<double>& values :
       {std::vector<double>{}, {kNaN}, {kInfinity, -kInfinity}, {0}, {5}, {-5}, {1e15}, {5, 5}}) {
    for (const bool with_zero : {false, true}) {
      const Range range = RangeOf(values, with_zero);
      EXPECT_LT(range.low, range.high);
      EXPECT_TRUE(std::isfinite(range.high - range.low));
      EXPECT_TRUE(!with_zero || range.low <= 0);
    }
  }
  EXPECT_EQ(RangeOf({2, 4, kNaN}, false).low, 2);
  EXPECT_EQ(RangeOf({2, 4, kNaN}, true).low, 0);
}

TEST(ThinCurveTest, KeepsPeaksAndGaps) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 10'000; ++i) points.push_back({i, i == 4321 ? 100.0 : std::sin(0.01 * i)});
  points[7000].y() = kNaN;
  const std::vector<Eigen::Vector2d> thin = ThinCurve(points, 100);
  EXPECT_LE(thin.size(), 500u);
  double highest = 0;
  int gaps = 0;
  double last_x = -1;
  for (const Eigen::Vector2d& x : thin) {
    EXPECT_GT(x.x(), last_x);
    last_x = x.x();
    if (x.allFinite()) {
      highest = std::max(highest, x.y());
    } else {
      ++gaps;
    }
  }
  EXPECT_EQ(highest, 100);
  EXPECT_EQ(gaps, 1);
  EXPECT_EQ(thin.back().x(), 9999);
}

}  // namespace
}  // namespace corbslam

#include "slam/util/bounded_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace corbslam {
namespace {

TEST(BoundedSampleTest, HoldsAllWhileThereIsRoom) {
  BoundedSample sample(3);
  EXPECT_EQ(sample.mean(), 0);
  EXPECT_EQ(sample.max(), 0);
  for (const double value : {4., 1., 7.}) sample.Add(value);
  EXPECT_EQ(sample.values(), (std::vector<double>{4, 1, 7}));
  EXPECT_EQ(sample.count(), 3u);
  EXPECT_EQ(sample.mean(), 4);
  EXPECT_EQ(sample.min(), 1);
  EXPECT_EQ(sample.max(), 7);
}

TEST(BoundedSampleTest, StaysBoundedAndFairWhenItGoesOn) {
  BoundedSample sample(1000);
  constexpr int kCount = 100000;
  for (int i = 0; i < kCount; ++i) sample.Add(i);
  EXPECT_EQ(sample.values().size(), 1000u);
  EXPECT_EQ(sample.count(), static_cast<uint64_t>(kCount));
  EXPECT_DOUBLE_EQ(sample.mean(), (kCount - 1) / 2.0);
  EXPECT_EQ(sample.max(), kCount - 1);
  // Neither the first nor the last values are preferred: five standard deviations of the median.
  std::vector<double> values = sample.values();
  std::nth_element(values.begin(), values.begin() + 500, values.end());
  EXPECT_NEAR(values[500], kCount / 2.0, 5 * kCount / 2.0 / std::sqrt(1000.0));
  EXPECT_GT(std::ranges::max(values), 0.98 * kCount);
  EXPECT_LT(std::ranges::min(values), 0.02 * kCount);
}

}  // namespace
}  // namespace corbslam

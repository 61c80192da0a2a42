#include "slam/util/median.h"

#include <gtest/gtest.h>

namespace corbslam {
namespace {

TEST(MedianTest, IsTheUpperOfTheTwoInTheMiddle) {
  EXPECT_EQ(Median<int>({7}), 7);
  EXPECT_EQ(Median<int>({9, 1, 4}), 4);
  EXPECT_EQ(Median<double>({4, 1, 3, 2}), 3);
}

TEST(MeanMedianTest, IsTheMeanOfTheTwoInTheMiddle) {
  EXPECT_EQ(MeanMedian({7}), 7);
  EXPECT_EQ(MeanMedian({9, 1, 4}), 4);
  EXPECT_EQ(MeanMedian({4, 1, 3, 2}), 2.5);
  EXPECT_EQ(MeanMedian({1, 2}), 1.5);
}

}  // namespace
}  // namespace corbslam

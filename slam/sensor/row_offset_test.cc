#include "slam/sensor/row_offset.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <random>

namespace corbslam {
namespace {

constexpr size_t kMany = 500;

// Shows pairs of a rig whose right picture lies lower by `truth_px`, as far as it is not put right
// yet.
void Drive(double truth_px, double scatter_px, int pairs, RowOffset& rows) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, scatter_px);
  for (int i = 0; i < pairs; ++i) {
    rows.Add({0.75 * (truth_px - rows.correction_px()) + noise(random), kMany});
  }
}

TEST(RowOffsetTest, ARigThatIsRightStaysAsItIs) {
  for (const double truth_px : {0.0, 0.05, -0.1}) {
    RowOffset rows;
    Drive(truth_px, 0.02, 300, rows);
    EXPECT_EQ(rows.correction_px(), 0) << truth_px;
  }
}

TEST(RowOffsetTest, WhatIsOffByPartsOfARowIsPutRight) {
  for (const double truth_px : {0.3, -0.4, 0.8}) {
    RowOffset rows;
    Drive(truth_px, 0.02, 9, rows);
    EXPECT_EQ(rows.correction_px(), 0) << truth_px;
    Drive(truth_px, 0.02, 30, rows);
    EXPECT_NEAR(rows.correction_px(), truth_px, 0.04) << truth_px;
  }
}

TEST(RowOffsetTest, ARigThatChangesIsFollowed) {
  RowOffset rows;
  Drive(0.3, 0.02, 30, rows);
  Drive(0.5, 0.02, 30, rows);
  EXPECT_NEAR(rows.correction_px(), 0.5, 0.04);
  Drive(0, 0.02, 30, rows);
  EXPECT_NEAR(rows.correction_px(), 0, 0.04);
}

TEST(RowOffsetTest, WhatPairsDoNotAgreeOnIsNoOffset) {
  // As of cameras that are not triggered together, on a road that shakes them.
  RowOffset rows;
  Drive(0, 0.8, 300, rows);
  EXPECT_EQ(rows.correction_px(), 0);
}

TEST(RowOffsetTest, DarkPairsTellNothing) {
  RowOffset rows;
  for (int i = 0; i < 100; ++i) rows.Add({0.5, 99});
  EXPECT_EQ(rows.correction_px(), 0);
}

TEST(RowOffsetTest, ARigThatIsFarOffIsMovedTwoRowsAtMost) {
  RowOffset rows;
  Drive(9, 0.02, 100, rows);
  EXPECT_EQ(rows.correction_px(), 2);
}

// A picture of which each row is brighter by ten than the one above.
cv::Mat Slope() {
  cv::Mat picture(20, 8, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y) picture.row(y).setTo(cv::Scalar(10 * y));
  return picture;
}

TEST(MoveUpTest, MovesByPartsOfARow) {
  for (const double rows_px : {0.0, 0.4, -0.4, 1.0, 1.7, -1.2, -2.0}) {
    const cv::Mat moved = MoveUp(Slope(), rows_px);
    ASSERT_EQ(moved.size(), Slope().size());
    for (int y = 4; y < 16; ++y) {
      EXPECT_NEAR(moved.at<uint8_t>(y, 3), 10 * (y + rows_px), 1) << rows_px << " at " << y;
    }
  }
}

TEST(MoveUpTest, WhatComesInRepeatsTheEdge) {
  EXPECT_EQ(MoveUp(Slope(), 2).at<uint8_t>(19, 0), 190);
  EXPECT_EQ(MoveUp(Slope(), -2).at<uint8_t>(0, 0), 0);
}

}  // namespace
}  // namespace corbslam

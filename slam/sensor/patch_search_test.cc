#include "slam/sensor/patch_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace corbslam {
namespace {

// A picture with structure of every size, the same for everybody; `at` says where in the world each
// pixel looks.
template <typename At>
cv::Mat Draw(At at) {
  cv::Mat picture(160, 200, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const Eigen::Vector2d w = at(Eigen::Vector2d(x, y));
      const double value = 128 + 30 * std::sin(0.43 * w.x() + std::sin(0.17 * w.y())) +
                           30 * std::cos(0.39 * w.y() + 0.11 * w.x()) +
                           45 * std::sin(0.09 * w.x() - 0.13 * w.y());
      picture.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(value);
    }
  }
  return picture;
}

HalvedPicture Source() {
  return HalvePicture(Draw([](const Eigen::Vector2d& p) { return p; }));
}

TEST(HalvePictureTest, EachPixelIsTheMeanOfFour) {
  cv::Mat grey(19, 33, CV_8UC1, cv::Scalar(0));
  grey.at<uint8_t>(2, 4) = 100;
  grey.at<uint8_t>(3, 5) = 102;
  const HalvedPicture halved = HalvePicture(grey);
  EXPECT_EQ(halved.levels[0].data, grey.data);
  EXPECT_EQ(halved.levels[1].size(), cv::Size(16, 9));
  EXPECT_EQ(halved.levels[1].at<uint8_t>(1, 2), 51);
  EXPECT_EQ(halved.levels[2].size(), cv::Size(8, 4));
  EXPECT_EQ(halved.levels[2].at<uint8_t>(0, 1), 13);
  EXPECT_EQ(halved.bytes(), 19U * 33 + 9 * 16 + 4 * 8 + 2 * 4 + 1 * 2);
}

TEST(FindPatchTest, FindsAPatchThatMovedToAPartOfAPixel) {
  const HalvedPicture source = Source();
  for (const auto& moved : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.3, -0.6),
                            Eigen::Vector2d(2.25, 1.5), Eigen::Vector2d(-1.4, 2.8)}) {
    const HalvedPicture now =
        HalvePicture(Draw([&](const Eigen::Vector2d& p) -> Eigen::Vector2d { return p - moved; }));
    const Eigen::Vector2d source_px(91.25, 73.5);
    const auto found = FindPatch(source, now,
                                 {.source_px = source_px,
                                  .source_from_now = Eigen::Matrix2d::Identity(),
                                  .predicted_px = source_px});
    ASSERT_TRUE(found.has_value()) << moved.transpose();
    EXPECT_LT((*found - source_px - moved).norm(), 0.1) << moved.transpose();
  }
}

TEST(FindPatchTest, FollowsWhatIsNearerTurnedAndBrighter) {
  const HalvedPicture source = Source();
  Eigen::Matrix2d source_from_now;
  const double scale = 0.7;
  const double angle = 0.2;
  source_from_now << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  source_from_now *= scale;
  const Eigen::Vector2d source_px(90, 75);
  const Eigen::Vector2d truth(104.3, 66.8);
  cv::Mat grey = Draw([&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return source_px + source_from_now * (p - truth);
  });
  grey.convertTo(grey, CV_8UC1, 0.6, 70);
  const auto found = FindPatch(source, HalvePicture(grey),
                               {.source_px = source_px,
                                .source_from_now = source_from_now,
                                .predicted_px = truth + Eigen::Vector2d(1.5, -1)});
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((*found - truth).norm(), 0.1);
}

TEST(FindPatchTest, FindsNothingWhereThereIsNothing) {
  const HalvedPicture source = Source();
  const Eigen::Vector2d middle(90, 75);
  const PatchSearch search = {
      .source_px = middle, .source_from_now = Eigen::Matrix2d::Identity(), .predicted_px = middle};
  const HalvedPicture grey = HalvePicture(cv::Mat(160, 200, CV_8UC1, cv::Scalar(90)));
  EXPECT_FALSE(FindPatch(source, grey, search).has_value()) << "a bare wall";
  EXPECT_FALSE(FindPatch(grey, source, search).has_value()) << "a patch of one";
  const HalvedPicture other = HalvePicture(Draw([](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return {1.7 * p.y(), 1.7 * p.x()};
  }));
  EXPECT_FALSE(FindPatch(source, other, search).has_value()) << "another scene";
  PatchSearch outside = search;
  outside.predicted_px = {198, 3};
  EXPECT_FALSE(FindPatch(source, source, outside).has_value());
  outside = search;
  outside.source_px = {-30, 200};
  EXPECT_FALSE(FindPatch(source, source, outside).has_value());
}

TEST(FindPatchTest, FollowsNoEdgeAlongItself) {
  cv::Mat edge(160, 200, CV_8UC1, cv::Scalar(60));
  edge.colRange(90, 200) = 180;
  const HalvedPicture halved = HalvePicture(edge);
  EXPECT_FALSE(FindPatch(halved, halved,
                         {.source_px = {90, 75},
                          .source_from_now = Eigen::Matrix2d::Identity(),
                          .predicted_px = {91, 77}})
                   .has_value());
}

}  // namespace
}  // namespace corbslam

#include "services/simulation/sequence/depth_image.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace corbslam {
namespace {

// Mean and standard deviation in metres of what is measured at one depth.
std::pair<double, double> Measure(float depth_m, uint64_t seed = 1, uint64_t stream = 0) {
  DepthImageOptions options;
  options.noise_seed = seed;
  const cv::Mat image = MakeDepthImage(cv::Mat(60, 80, CV_32FC1, depth_m), options, stream);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  return {mean[0] / 5000, deviation[0] / 5000};
}

TEST(DepthImageTest, NoiseGrowsWithTheSquareOfTheDepth) {
  for (const double depth : {1.0, 2.0, 4.0}) {
    const auto [mean, deviation] = Measure(static_cast<float>(depth));
    EXPECT_NEAR(mean, depth, 0.001 * depth);
    EXPECT_NEAR(deviation, 1.425e-3 * depth * depth, 0.1e-3 * depth * depth);
  }
}

TEST(DepthImageTest, HasNothingOutsideItsRange) {
  for (const float depth : {0.0F, 0.4F, 8.5F, 100.0F}) EXPECT_EQ(Measure(depth).first, 0) << depth;
}

TEST(DepthImageTest, NoiseIsThatOfTheSeedAndTheStream) {
  const cv::Mat depth(30, 40, CV_32FC1, 3.0F);
  const auto differs = [&](uint64_t seed, uint64_t stream) {
    DepthImageOptions options;
    const cv::Mat first = MakeDepthImage(depth, options, 0);
    options.noise_seed = seed;
    return cv::norm(first, MakeDepthImage(depth, options, stream), cv::NORM_INF) > 0;
  };
  EXPECT_FALSE(differs(1, 0));
  EXPECT_TRUE(differs(2, 0));
  EXPECT_TRUE(differs(1, 1));
}

}  // namespace
}  // namespace corbslam

#include "slam/map/feature_grid.h"

#include <algorithm>
#include <random>

#include "gtest/gtest.h"

namespace corbslam {
namespace {

TEST(FeatureGridTest, FindsTheSameKeypointsAsASearchOverAll) {
  const Camera camera = {.width_px = 641, .height_px = 479};
  std::mt19937 random(1);
  std::uniform_real_distribution<float> x(-5, 645), y(-5, 485);
  std::vector<Keypoint> keypoints;
  for (int i = 0; i < 3000; ++i) {
    keypoints.push_back(
        {.x_px = x(random), .y_px = y(random), .octave = static_cast<uint8_t>(i % 8)});
  }
  const FeatureGrid grid(camera, keypoints);
  for (int trial = 0; trial < 200; ++trial) {
    const double px = x(random), py = y(random), radius = 1 + trial;
    std::vector<uint32_t> expected, found;
    for (uint32_t i = 0; i < keypoints.size(); ++i) {
      const Keypoint& k = keypoints[i];
      if (k.octave >= 2 && k.octave <= 5 && std::abs(k.x_px - px) <= radius &&
          std::abs(k.y_px - py) <= radius) {
        expected.push_back(i);
      }
    }
    grid.FindNear(keypoints, px, py, radius, 2, 5, found);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

TEST(FeatureGridTest, EmptyGridFindsNothing) {
  std::vector<uint32_t> found;
  FeatureGrid().FindNear({}, 1, 1, 100, 0, 7, found);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace corbslam

// Tests OthersScale on frames that see points at known distances.
#include "client_agent/tracking/others_scale.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "slam/camera/testing/test_camera.h"

namespace corbslam::client_agent {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr LocalMapId kOwn{1};
constexpr LocalMapId kOther{2};
constexpr LocalMapId kThird{3};
constexpr double kNoise_px = 0.3;

class OthersScaleTest : public ::testing::Test {
 protected:
  // Lets the frame see points of a map that is `scale` times as large as the world.
  void See(LocalMapId local_map, double scale, int points) {
    std::uniform_real_distribution<double> depth_m(4, 40);
    std::normal_distribution<double> noise_px(0, kNoise_px);
    for (int i = 0; i < points; ++i) {
      const double z = depth_m(random_);
      Keypoint keypoint;
      keypoint.disparity_px =
          static_cast<float>(camera_.fx_px * camera_.baseline_m / z + noise_px(random_));
      keypoints_.push_back(keypoint);
      Association association;
      association.kind = Association::Kind::kMapPoint;
      association.id = {local_map, next_point_++};
      association.position_in_map = {0, 0, scale * z};
      associations_.push_back(association);
    }
  }
  // Shows what was seen since the last frame.
  std::vector<MapContradiction> Show() {
    Features features;
    features.keypoints = std::exchange(keypoints_, {});
    features.descriptors.resize(features.keypoints.size());
    Frame frame =
        MakeFrame({.camera = std::make_shared<Camera>(camera_), .features = std::move(features)});
    frame.associations = std::exchange(associations_, {});
    return scale_.Add(frame, kOwn);
  }
  // Shows frames until one is told of, at most so many; returns how many it took, 0 for none.
  int ShowUntilTold(int most, double scale, std::vector<MapContradiction>& told) {
    for (int frame = 1; frame <= most; ++frame) {
      See(kOther, scale, 100);
      told = Show();
      if (!told.empty()) return frame;
    }
    return 0;
  }

  Camera camera_ = testing::CarCamera();
  uint32_t next_point_ = 0;
  std::mt19937 random_{7};
  std::vector<Keypoint> keypoints_;
  std::vector<Association> associations_;
  OthersScale scale_;
};

TEST_F(OthersScaleTest, TellsAMapThatIsTooLargeOrTooSmallAndByHowMuch) {
  for (const double scale : {0.97, 0.996, 1.004, 1.03}) {
    scale_ = OthersScale();
    std::vector<MapContradiction> told;
    const bool is_gross = std::abs(scale - 1) > 0.02;
    EXPECT_EQ(ShowUntilTold(100, scale, told), is_gross ? 20 : 40) << scale;
    ASSERT_THAT(told, SizeIs(1));
    EXPECT_EQ(told[0].local_map, kOther);
    EXPECT_NEAR(told[0].scale, scale, 5 * told[0].scale_sigma);
    EXPECT_LT(told[0].scale_sigma, 2e-3);
  }
}

TEST_F(OthersScaleTest, ARightMapStaysARightOneHoweverLongItIsSeen) {
  std::vector<MapContradiction> told;
  EXPECT_EQ(ShowUntilTold(3000, 1, told), 0);
}

TEST_F(OthersScaleTest, AMapThatIsPutToItsPlaceStepByStepIsOfTheRightSize) {
  std::vector<MapContradiction> told;
  EXPECT_EQ(ShowUntilTold(10, 0.945, told), 0);
  EXPECT_EQ(ShowUntilTold(10, 0.976, told), 0);
  EXPECT_EQ(ShowUntilTold(300, 1, told), 0);
}

TEST_F(OthersScaleTest, WhatIsOffHereAndRightThereIsNoScale) {
  std::vector<MapContradiction> told;
  for (int place = 0; place < 20; ++place) {
    EXPECT_EQ(ShowUntilTold(15, place % 2 == 0 ? 1.01 : 0.999, told), 0) << place;
  }
}

TEST_F(OthersScaleTest, ErrorsOfTheSamePointsInEachFrameDoNotAddUp) {
  // Forty points, a tenth of the distance off, seen again and again.
  for (uint32_t seed = 0; seed < 50; ++seed) {
    scale_ = OthersScale();
    for (int frame = 0; frame < 160; ++frame) {
      random_.seed(seed);
      next_point_ = 0;
      std::normal_distribution<double> off(1, 0.1);
      for (int point = 0; point < 40; ++point) See(kOther, off(random_), 1);
      ASSERT_THAT(Show(), IsEmpty()) << "seed " << seed << ", frame " << frame;
    }
  }
}

TEST_F(OthersScaleTest, PointsThatAreOffThisWayAndThatMakeNoMapSmaller) {
  std::normal_distribution<double> off(0, 0.04);
  for (int frame = 0; frame < 1000; ++frame) {
    for (int point = 0; point < 100; ++point) See(kOther, std::exp(off(random_)), 1);
    ASSERT_THAT(Show(), IsEmpty()) << frame;
  }
}

TEST_F(OthersScaleTest, TellsOfEachOnceAndOfNoneBeside) {
  std::vector<MapContradiction> told;
  for (int frame = 0; frame < 200; ++frame) {
    See(kOwn, 1.02, 100);
    See(kOther, 1.02, 100);
    See(kThird, 1, 100);
    for (const MapContradiction& found : Show()) told.push_back(found);
  }
  ASSERT_THAT(told, SizeIs(1));
  EXPECT_EQ(told[0].local_map, kOther);
}

TEST_F(OthersScaleTest, FewPointsAreNoSample) {
  for (int frame = 0; frame < 200; ++frame) {
    See(kOther, 1.02, 29);
    EXPECT_THAT(Show(), IsEmpty());
  }
}

TEST_F(OthersScaleTest, ACameraWithoutDistancesSaysNothing) {
  camera_.baseline_m = 0;
  for (int frame = 0; frame < 100; ++frame) {
    See(kOther, 1.02, 100);
    EXPECT_THAT(Show(), IsEmpty());
  }
}

}  // namespace
}  // namespace corbslam::client_agent

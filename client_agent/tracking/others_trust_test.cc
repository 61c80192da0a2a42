#include "client_agent/tracking/others_trust.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{1};
constexpr LocalMapId kOthers{2};

struct Seen {
  Frame frame;
  absl::flat_hash_set<MapPointId> hearsay;
};

// Returns a frame at the origin that sees own points where they are, and hearsay that others have
// `error` beside that.
Seen See(uint32_t own, uint32_t hearsay, const Eigen::Vector3d& error, uint32_t seed = 1) {
  const Camera camera = testing::SyntheticCamera();
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> noise_px(0, 0.4);
  Seen seen;
  Features features;
  std::vector<Association> associations;
  for (uint32_t i = 0; i < own + hearsay; ++i) {
    const bool is_hearsay = i >= own;
    const Eigen::Vector2d pixel(camera.width_px * uniform(random),
                                camera.height_px * uniform(random));
    const double z = 4 + 16 * uniform(random);
    Keypoint& keypoint = features.keypoints.emplace_back();
    keypoint.x_px = static_cast<float>(pixel.x() + noise_px(random));
    keypoint.y_px = static_cast<float>(pixel.y() + noise_px(random));
    keypoint.disparity_px = static_cast<float>(DisparityFromDepth(camera, z) + noise_px(random));
    features.descriptors.emplace_back();
    Association& association = associations.emplace_back();
    association.kind = Association::Kind::kMapPoint;
    association.id = {is_hearsay ? kOthers : kOwn, i};
    association.position_in_map = Unproject(camera, pixel.x(), pixel.y(), z);
    if (!is_hearsay) continue;
    association.position_in_map += error;
    seen.hearsay.insert(association.id);
  }
  seen.frame = MakeFrame(0, std::make_shared<Camera>(camera), std::move(features));
  seen.frame.associations = std::move(associations);
  return seen;
}

double RatioOf(const Seen& seen) {
  const auto innovations = MeasureInnovations(seen.frame, seen.hearsay);
  return innovations.has_value() && innovations->size() == 1 ? innovations->front().ratio : -1;
}

TEST(MeasureInnovationsTest, OthersPointsThatFitErrAsOwnOnesDo) {
  for (uint32_t seed = 1; seed < 10; ++seed) {
    const double ratio = RatioOf(See(200, 200, Eigen::Vector3d::Zero(), seed));
    EXPECT_GT(ratio, 0.6) << seed;
    EXPECT_LT(ratio, 1.7) << seed;
  }
}

TEST(MeasureInnovationsTest, WhatLiesElsewhereStandsOutThoughMostPointsAreOthers) {
  EXPECT_GT(RatioOf(See(60, 600, {0.1, 0, 0})), 25);
}

TEST(MeasureInnovationsTest, FewOwnPointsSayNothing) {
  const Seen seen = See(40, 200, Eigen::Vector3d::Zero());
  EXPECT_FALSE(MeasureInnovations(seen.frame, seen.hearsay).has_value());
  EXPECT_FALSE(MeasureInnovations(seen.frame, {}).has_value());
}

TEST(MeasureInnovationsTest, LittleHearsayIsNoSample) {
  const Seen seen = See(200, 10, {1, 0, 0});
  const auto innovations = MeasureInnovations(seen.frame, seen.hearsay);
  ASSERT_TRUE(innovations.has_value());
  EXPECT_TRUE(innovations->empty());
}

TEST(OthersTrustTest, WhatFitsWorseDrawsThePoseLess) {
  Seen plain = See(100, 300, {0.05, 0, 0});
  Seen weighed = plain;
  OthersTrust trust;
  for (int frame = 0; frame < 30; ++frame) trust.Add({{kOthers, 16}});
  trust.Weigh(weighed.hearsay, true, weighed.frame);
  const InlierCount count = OptimiseFramePose(Rigid3d::Identity(), kOwn, weighed.frame);
  OptimiseFramePose(Rigid3d::Identity(), kOwn, plain.frame);
  const double error = weighed.frame.camera_from_map.translation.norm();
  EXPECT_LT(error, 0.6 * plain.frame.camera_from_map.translation.norm());
  EXPECT_GT(count.foreign, 0);
}

TEST(OthersTrustTest, WhatIsNotWellKnownMustFitAsWell) {
  Seen seen = See(200, 200, {0.15, 0, 0});
  OthersTrust trust;
  for (int frame = 0; frame < 6; ++frame) trust.Add({{kOthers, 20}});
  trust.Weigh(seen.hearsay, true, seen.frame);
  OptimiseFramePose(Rigid3d::Identity(), kOwn, seen.frame);
  for (size_t i = 0; i < seen.frame.associations.size(); ++i) {
    if (seen.frame.associations[i].id.local_map != kOthers) continue;
    EXPECT_LT(NormalisedError2(seen.frame, i, seen.frame.camera_from_map), 7.815 / 2.366);
  }
}

TEST(OthersTrustTest, AContradictionOverSomeFramesIsNewsOnceAndEnds) {
  OthersTrust trust;
  EXPECT_TRUE(trust.Add({{kOthers, 1000}}).empty()) << "one frame says little";
  std::vector<OthersNews> news;
  for (int frame = 0; frame < 20; ++frame) {
    for (const OthersNews& one : trust.Add({{kOthers, 1000}})) news.push_back(one);
  }
  ASSERT_EQ(news.size(), 1u);
  EXPECT_TRUE(news[0].contradicts);
  EXPECT_EQ(news[0].local_map, kOthers);
  EXPECT_GE(news[0].deviations, 5);
  for (int frame = 0; frame < 20; ++frame) {
    for (const OthersNews& one : trust.Add({{kOthers, 1}})) news.push_back(one);
  }
  ASSERT_EQ(news.size(), 2u);
  EXPECT_FALSE(news[1].contradicts);
}

TEST(OthersTrustTest, WhatContradictsIsNotDrivenByWhereOwnPointsAreEnough) {
  OthersTrust trust;
  for (int frame = 0; frame < 20; ++frame) trust.Add({{kOthers, 1000}});
  Seen seen = See(200, 100, Eigen::Vector3d::Zero());
  Seen alone = seen;
  trust.Weigh(seen.hearsay, true, seen.frame);
  EXPECT_EQ(OptimiseFramePose(Rigid3d::Identity(), kOwn, seen.frame).foreign, 0);
  // Nothing else holds this frame.
  trust.Weigh(alone.hearsay, false, alone.frame);
  EXPECT_GT(OptimiseFramePose(Rigid3d::Identity(), kOwn, alone.frame).foreign, 50);
}

}  // namespace
}  // namespace corbslam::client_agent

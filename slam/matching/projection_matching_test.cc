#include "slam/matching/projection_matching.h"

#include <gtest/gtest.h>

#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

class ProjectionMatchingTest : public ::testing::Test {
 protected:
  ProjectionMatchingTest() : scene_(testing::MakeSyntheticScene({.keyframes = 6, .points = 400})) {
    for (const auto& [id, point] : scene_.map.points()) points_.push_back(MakeMatchPoint(point));
    target_ = &std::next(scene_.map.keyframes().begin(), 3)->second;
  }

  std::vector<SearchWindow> Windows(const Rigid3d& camera_from_map, std::vector<MapPointId>& ids) {
    std::vector<SearchWindow> windows;
    for (const MatchPoint& point : points_) {
      const auto view = PredictView(point, target_->camera(), camera_from_map);
      if (!view.has_value()) continue;
      windows.push_back(MakeSearchWindow(point, *view, 3));
      windows.back().min_octave = 0;
      windows.back().max_octave = ScalePyramid::kLevels - 1;
      ids.push_back(point.id);
    }
    return windows;
  }

  testing::SyntheticScene scene_;
  std::vector<MatchPoint> points_;
  const Keyframe* target_ = nullptr;
};

TEST_F(ProjectionMatchingTest, FindsThePointsThatTheKeyframeSees) {
  std::vector<MapPointId> ids;
  const auto windows = Windows(target_->camera_from_map, ids);
  const auto matches = MatchWindows(windows, *target_->payload, {}, {.max_ratio = 0.8});
  int right = 0;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] == kNoMatch) continue;
    EXPECT_EQ(target_->points[matches[i]], ids[i]);
    ++right;
  }
  EXPECT_GT(right, 100);
}

TEST_F(ProjectionMatchingTest, LeavesTakenKeypointsAlone) {
  std::vector<MapPointId> ids;
  const auto windows = Windows(target_->camera_from_map, ids);
  const std::vector<char> taken(target_->keypoints().size(), 1);
  for (const uint32_t match : MatchWindows(windows, *target_->payload, taken, {})) {
    EXPECT_EQ(match, kNoMatch);
  }
}

TEST_F(ProjectionMatchingTest, DisparityMustAgree) {
  std::vector<MapPointId> ids;
  auto windows = Windows(target_->camera_from_map, ids);
  for (SearchWindow& window : windows) window.disparity_px += 200;
  for (const uint32_t match : MatchWindows(windows, *target_->payload, {}, {})) {
    EXPECT_EQ(match, kNoMatch);
  }
}

TEST_F(ProjectionMatchingTest, OfTwoWindowsTheNearerDescriptorGetsTheKeypoint) {
  SearchWindow near;
  near.pixel = target_->keypoints()[0].Pixel();
  near.radius_px = 2;
  near.max_octave = ScalePyramid::kLevels - 1;
  near.descriptor = target_->descriptors()[0];
  SearchWindow far = near;
  far.descriptor.words[0] ^= 0xff;
  const auto matches = MatchWindows({{far, near}}, *target_->payload, {}, {});
  EXPECT_EQ(matches[0], kNoMatch);
  EXPECT_EQ(matches[1], 0u);
}

TEST_F(ProjectionMatchingTest, OddOrientationsAreDropped) {
  std::vector<MapPointId> ids;
  auto windows = Windows(target_->camera_from_map, ids);
  windows[0].angle_rad += 2;
  const auto all = MatchWindows(windows, *target_->payload, {}, {});
  const auto kept = MatchWindows(windows, *target_->payload, {}, {.check_orientation = true});
  ASSERT_NE(all[0], kNoMatch);
  EXPECT_EQ(kept[0], kNoMatch);
  EXPECT_EQ(kept[1], all[1]);
}

TEST_F(ProjectionMatchingTest, NothingIsPredictedBehindTheCameraOrFromTheWrongSide) {
  MatchPoint point = points_.front();
  const Rigid3d turned{Eigen::Quaterniond(0, 0, 1, 0), Eigen::Vector3d::Zero()};
  EXPECT_FALSE(
      PredictView(point, target_->camera(), turned * target_->camera_from_map).has_value());
  for (MatchPoint seen : points_) {
    seen.normal_in_map = -seen.normal_in_map;
    EXPECT_FALSE(PredictView(seen, target_->camera(), target_->camera_from_map).has_value());
  }
}

}  // namespace
}  // namespace corbslam

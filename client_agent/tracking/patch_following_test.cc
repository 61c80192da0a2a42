#include "client_agent/tracking/patch_following.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <set>

#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kThisMap{7};
constexpr double kWall_m = 4;

StereoCalibration WallRig() {
  StereoCalibration rig;
  rig.camera = {.fx_px = 300,
                .fy_px = 300,
                .cx_px = 159.5,
                .cy_px = 119.5,
                .width_px = 320,
                .height_px = 240,
                .baseline_m = 0.2,
                .close_depth_m = 8};
  return rig;
}

// What a camera sees of a wall that is kWall_m ahead of the map's origin.
cv::Mat DrawTheWall(const Camera& camera, const Rigid3d& camera_from_map) {
  const Rigid3d map_from_camera = camera_from_map.Inverse();
  cv::Mat picture(camera.height_px, camera.width_px, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const Eigen::Vector3d ray = map_from_camera.rotation * Unproject(camera, x, y, 1);
      const double length = (kWall_m - map_from_camera.translation.z()) / ray.z();
      const Eigen::Vector3d at = map_from_camera.translation + length * ray;
      const double value = 128 + 45 * std::sin(21 * at.x() + std::sin(13 * at.y())) +
                           40 * std::cos(23 * at.y() - 7 * at.x()) +
                           30 * std::sin(5 * at.x() + 6 * at.y());
      picture.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(value);
    }
  }
  return picture;
}

class FollowPatchesTest : public ::testing::Test {
 protected:
  FollowPatchesTest() : keyframe_(HalvePicture(DrawTheWall(camera(), Rigid3d::Identity()))) {
    for (int x = 40; x <= 280; x += 20) {
      for (int y = 40; y <= 200; y += 20) {
        PatchSource source;
        source.point = {kThisMap, static_cast<uint32_t>(sources_.size())};
        source.position_in_map = Unproject(camera(), x, y, kWall_m);
        source.octave = 5;
        source.picture = &keyframe_;
        source.keypoint.x_px = static_cast<float>(x);
        source.keypoint.y_px = static_cast<float>(y);
        sources_.push_back(source);
      }
    }
  }

  const Camera& camera() const { return sensor_->camera(); }
  // Follows the wall from `predicted` on while the camera is at `truth`.
  Frame Follow(const Rigid3d& truth, const Rigid3d& predicted) {
    images_.grey = DrawTheWall(camera(), truth);
    const FreshPicture fresh{sensor_.get(), &images_, HalvePicture(images_.grey)};
    return FollowPatches(fresh, std::make_shared<const Camera>(camera()), predicted, sources_,
                         PatchSearch::kLevels - 1);
  }

  std::unique_ptr<Sensor> sensor_ = *MakeSensor(WallRig(), {});
  HalvedPicture keyframe_;
  std::vector<PatchSource> sources_;
  SensorImages images_;
};

TEST_F(FollowPatchesTest, FindsTheWallWhereTheCameraSeesItAndThePoseByThat) {
  Rigid3d truth;
  truth.translation = {-0.1, 0.05, -0.3};
  truth.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.2, 0.3, 1).normalized());
  Rigid3d predicted = truth;
  predicted.translation += Eigen::Vector3d(0.03, -0.02, 0);
  Frame frame = Follow(truth, predicted);
  ASSERT_GT(frame.keypoints().size(), 3 * sources_.size() / 4);
  ASSERT_EQ(frame.associations.size(), frame.keypoints().size());
  ASSERT_EQ(frame.descriptors().size(), frame.keypoints().size());
  double worst_px = 0;
  for (size_t i = 0; i < frame.keypoints().size(); ++i) {
    const Eigen::Vector3d at = truth * frame.associations[i].position_in_map;
    worst_px = std::max(worst_px, (frame.keypoints()[i].Pixel() - Project(camera(), at)).norm());
    EXPECT_FALSE(frame.keypoints()[i].HasDepth()) << "of stereo only a search tells it";
    EXPECT_EQ(frame.keypoints()[i].octave, 3);
  }
  EXPECT_LT(worst_px, 0.5);
  EXPECT_GT(OptimiseFramePose(predicted, kThisMap, frame).map_points, 50);
  EXPECT_LT((frame.camera_from_map.translation - truth.translation).norm(), 0.005);
}

TEST_F(FollowPatchesTest, FindsNothingOfWhatIsOutOfSightOrUnderTheMask) {
  Rigid3d behind;
  behind.translation.z() = -9;
  EXPECT_EQ(Follow(Rigid3d::Identity(), behind).keypoints().size(), 0u);
  cv::Mat mask(240, 320, CV_8UC1, cv::Scalar(255));
  mask.colRange(0, 160) = 0;
  ASSERT_TRUE(sensor_->SetMask(mask).ok());
  const Frame half = Follow(Rigid3d::Identity(), Rigid3d::Identity());
  EXPECT_GT(half.keypoints().size(), 20u);
  for (const Keypoint& keypoint : half.keypoints()) EXPECT_GT(keypoint.x_px, 155);
}

TEST(KeyframePicturesTest, AreCopiesOfTheNewest) {
  KeyframePictures pictures;
  cv::Mat grey(64, 64, CV_8UC1, cv::Scalar(9));
  for (uint32_t i = 0; i <= KeyframePictures::kMost; ++i) {
    pictures.Add({kThisMap, i}, HalvePicture(grey));
  }
  EXPECT_EQ(pictures.Find({kThisMap, 0}), nullptr);
  grey = 200;
  const HalvedPicture* const first = pictures.Find({kThisMap, 1});
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->levels[0].at<uint8_t>(5, 5), 9);
}

TEST(FindPatchSourcesTest, AreOfTheNewestOwnKeyframeWithAPictureAndSpreadOverThePicture) {
  testing::SyntheticSceneOptions options;
  options.keyframes = 6;
  options.points = 600;
  options.step_m = 0.1;
  const testing::SyntheticScene scene = testing::MakeSyntheticScene(options);
  const Keyframe& now = *scene.map.FindKeyframe({options.local_map, 5});
  std::vector<PointInView> points;
  for (const auto& [id, point] : scene.map.points()) {
    const Eigen::Vector3d at = now.camera_from_map * point.position_in_map;
    if (at.z() <= 0 || !IsInImage(scene.camera, Project(scene.camera, at))) continue;
    points.push_back({MakeMatchPoint(point), {.pixel = Project(scene.camera, at), .octave = 2}});
  }
  KeyframePictures pictures;
  EXPECT_TRUE(
      FindPatchSources(scene.map, options.local_map, points, scene.camera, pictures, 1000).empty());
  const HalvedPicture picture = HalvePicture(cv::Mat(64, 64, CV_8UC1, cv::Scalar(1)));
  pictures.Add({options.local_map, 2}, picture);
  pictures.Add({options.local_map, 4}, picture);
  const std::vector<PatchSource> sources =
      FindPatchSources(scene.map, options.local_map, points, scene.camera, pictures, 1000);
  ASSERT_GT(sources.size(), 100u);
  std::set<std::pair<int, int>> parts;
  for (size_t i = 0; i < sources.size(); ++i) {
    const MapPoint& point = *scene.map.FindPoint(sources[i].point);
    const bool newest_sees = point.observations.contains({options.local_map, 4});
    EXPECT_EQ(sources[i].picture, pictures.Find({options.local_map, newest_sees ? 4U : 2U}));
    if (i >= 20) continue;
    const Eigen::Vector2d pixel =
        Project(scene.camera, now.camera_from_map * point.position_in_map);
    const double side = scene.camera.width_px / 16.0;
    parts.insert({static_cast<int>(pixel.x() / side), static_cast<int>(pixel.y() / side)});
  }
  EXPECT_EQ(parts.size(), 20u) << "the first ones are each of another part";
  EXPECT_TRUE(
      FindPatchSources(scene.map, LocalMapId{0xf00}, points, scene.camera, pictures, 1000).empty());
}

}  // namespace
}  // namespace corbslam::client_agent

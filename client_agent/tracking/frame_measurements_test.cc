#include "client_agent/tracking/frame_measurements.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "client_agent/map/provisional_keyframes.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

// Eight keyframes in a row with noise in their pixels and none in their poses. A frame stands where
// the last but one of them does, and sees the same points exactly.
class FrameMeasurementsTest : public ::testing::Test {
 protected:
  static constexpr uint32_t kSameView = 6;

  FrameMeasurementsTest() : scene_(testing::MakeSyntheticScene(Options())) {
    const Keyframe& view = *scene_.map.FindKeyframe(Id(kSameView));
    Features features = view.payload->features;
    frame_.associations.resize(features.keypoints.size());
    for (size_t i = 0; i < features.keypoints.size(); ++i) {
      const MapPoint* point = scene_.map.FindPoint(view.points[i]);
      if (point == nullptr) continue;
      frame_.associations[i] = {Association::Kind::kMapPoint, point->id, point->position_in_map};
      const Eigen::Vector3d in_camera = view.camera_from_map * point->position_in_map;
      const Eigen::Vector2d pixel = Project(scene_.camera, in_camera);
      features.keypoints[i].x_px = static_cast<float>(pixel.x());
      features.keypoints[i].y_px = static_cast<float>(pixel.y());
      features.keypoints[i].disparity_px =
          static_cast<float>(DisparityFromDepth(scene_.camera, in_camera.z()));
    }
    frame_.payload = MakeKeyframePayload({}, 0, 0, view.payload->camera, features);
    frame_.reference = view.id();
    frame_.camera_from_map = view.camera_from_map;
  }

  static testing::SyntheticSceneOptions Options() {
    testing::SyntheticSceneOptions options;
    options.keyframes = 8;
    options.points = 600;
    options.step_m = 0.2;
    options.pixel_noise_px = 0.5;
    return options;
  }
  static KeyframeId Id(uint32_t index) { return {Options().local_map, index}; }

  std::vector<KeypointMeasurement> Find(const Map& map) const {
    return FindMeasurements(map, Options().local_map, frame_);
  }

  // Returns the root mean square of what the keyframe's keypoints differ from the truth, in pixels.
  double PixelError(const std::vector<Keypoint>& keypoints, KeyframeId id) const {
    const Keyframe& keyframe = *scene_.map.FindKeyframe(id);
    double sum = 0;
    int count = 0;
    for (size_t i = 0; i < keypoints.size(); ++i) {
      const MapPoint* point = scene_.map.FindPoint(keyframe.points[i]);
      if (point == nullptr) continue;
      sum += (keypoints[i].Pixel() -
              Project(scene_.camera, keyframe.camera_from_map * point->position_in_map))
                 .squaredNorm();
      ++count;
    }
    return std::sqrt(sum / count);
  }

  testing::SyntheticScene scene_;
  Frame frame_;
};

TEST_F(FrameMeasurementsTest, BringTheNewestKeyframesNearerToTheTruth) {
  const std::vector<KeypointMeasurement> measurements = Find(scene_.map);
  ASSERT_GT(measurements.size(), 100u);
  MeasurementBook book;
  book.Add(measurements);
  for (const auto& [id, of_keyframe] : book.TakeUpTo(Id(7))) {
    const std::vector<Keypoint>& before = scene_.map.FindKeyframe(id)->keypoints();
    EXPECT_LT(PixelError(Averaged(before, of_keyframe), id), 0.8 * PixelError(before, id))
        << ToString(id);
  }
}

TEST_F(FrameMeasurementsTest, APointsOwnErrorCancels) {
  Map displaced = scene_.map;
  for (const auto& [id, point] : scene_.map.points()) {
    displaced.SetPosition(id, point.position_in_map + Eigen::Vector3d(0.01, 0, 0));
  }
  const std::vector<KeypointMeasurement> measurements = Find(scene_.map);
  const std::vector<KeypointMeasurement> of_displaced = Find(displaced);
  ASSERT_EQ(measurements.size(), of_displaced.size());
  for (size_t i = 0; i < measurements.size(); ++i) {
    EXPECT_LT((measurements[i].shift_px - of_displaced[i].shift_px).norm(), 0.05);
  }
}

TEST_F(FrameMeasurementsTest, AreOfTheNewestThatSeesThePointIfItIsProvisional) {
  const KeyframeId settled = NewestBut(scene_.map, Options().local_map, kProvisionalKeyframes);
  ASSERT_EQ(settled, Id(1));
  for (const KeypointMeasurement& measurement : Find(scene_.map)) {
    EXPECT_GT(measurement.keyframe, settled);
    const MapPointId point =
        scene_.map.FindKeyframe(measurement.keyframe)->points[measurement.keypoint];
    EXPECT_EQ(scene_.map.FindPoint(point)->observations.rbegin()->first, measurement.keyframe);
  }
}

TEST_F(FrameMeasurementsTest, WhatNoiseDoesNotExplainIsNone) {
  const size_t all = Find(scene_.map).size();
  Features features = frame_.payload->features;
  for (Keypoint& keypoint : features.keypoints) keypoint.x_px += 30;
  frame_.payload = MakeKeyframePayload({}, 0, 0, frame_.payload->camera, features);
  EXPECT_LT(Find(scene_.map).size(), all / 100);
}

TEST_F(FrameMeasurementsTest, WithoutItsReferenceAFrameHasNone) {
  frame_.reference = Id(99);
  EXPECT_TRUE(Find(scene_.map).empty());
}

TEST_F(FrameMeasurementsTest, OthersKeyframesGetNone) {
  EXPECT_TRUE(FindMeasurements(scene_.map, LocalMapId{99}, frame_).empty());
}

}  // namespace
}  // namespace corbslam::client_agent

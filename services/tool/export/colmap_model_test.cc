#include "services/tool/export/colmap_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "services/testing/test_path.h"
#include "services/tool/export/robot_colours.h"
#include "services/tool/export/testing/colmap_reader.h"

namespace corbslam::services {
namespace {

using testing::ColmapModel;
using ::testing::HasSubstr;

constexpr LocalMapId kMapA{0xa};
constexpr LocalMapId kMapB{0xb};

Camera MakeCamera(double fx_px) {
  return {.fx_px = fx_px,
          .fy_px = fx_px + 1,
          .cx_px = 320,
          .cy_px = 240,
          .width_px = 640,
          .height_px = 480,
          .baseline_m = 0.1,
          .close_depth_m = 4};
}

Eigen::Vector3d Place(uint32_t i) { return {0.1 * i - 1, 0.3 - 0.05 * i, 4 + 0.2 * i}; }

// Makes a keyframe that sees the points i with i % step == 0 exactly, and has one keypoint that
// sees none.
Keyframe MakeKeyframe(KeyframeId id, double fx_px, const Rigid3d& camera_from_map, uint32_t points,
                      uint32_t step) {
  Features features;
  const Camera camera = MakeCamera(fx_px);
  for (uint32_t i = 0; i < points; i += step) {
    const Eigen::Vector2d pixel = Project(camera, camera_from_map * Place(i));
    features.keypoints.push_back(
        {.x_px = static_cast<float>(pixel.x()), .y_px = static_cast<float>(pixel.y())});
  }
  features.keypoints.push_back({.x_px = 5, .y_px = 6});
  features.descriptors.resize(features.keypoints.size());
  Keyframe keyframe;
  keyframe.payload = MakeKeyframePayload(id, 1'000'000'000 + id.index, 0,
                                         std::make_shared<const Camera>(camera), features);
  keyframe.camera_from_map = camera_from_map;
  return keyframe;
}

// Makes two robots of a keyframe each, with a camera each; the points are the first robot's, and
// one point is the second robot's, which nobody sees.
Map MakeMap() {
  constexpr uint32_t kPoints = 20;
  Map map;
  const Rigid3d turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY())),
                       {0.2, -0.1, 0.3}};
  map.AddKeyframe(MakeKeyframe({kMapA, 0}, 500, Rigid3d(), kPoints, 1));
  map.AddKeyframe(MakeKeyframe({kMapB, 7}, 600, turned, kPoints, 2));
  for (uint32_t i = 0; i < kPoints; ++i) {
    MapPoint point;
    point.id = {kMapA, i};
    point.position_in_map = Place(i);
    map.AddPoint(point);
    map.AddObservation(point.id, {kMapA, 0}, i);
    if (i % 2 == 0) map.AddObservation(point.id, {kMapB, 7}, i / 2);
  }
  MapPoint unseen;
  unseen.id = {kMapB, 0};
  map.AddPoint(unseen);
  return map;
}

ColmapSource MakeSource() {
  ColmapSource source;
  source.robots = {{kMapA, "alpha"}, {kMapB, "bravo"}};
  return source;
}

class ColmapModelTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(folder_); }

  const std::string folder_ = TestPath("folder") + "/model";
};

TEST_F(ColmapModelTest, ProjectsItsPointsOntoItsKeypoints) {
  const auto counts = WriteColmapModel(MakeMap(), MakeSource(), folder_);
  ASSERT_TRUE(counts.ok()) << counts.status();
  EXPECT_EQ(counts->observations, 30u);
  const auto model = testing::ReadColmapModel(folder_);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->cameras.size(), 2u);
  EXPECT_EQ(model->images.size(), 2u);
  EXPECT_EQ(model->points.size(), 20u);
  const std::vector<double> errors_px = testing::ReprojectionErrors_px(*model);
  ASSERT_EQ(errors_px.size(), 30u);
  // Keypoints are written to a thousandth of a pixel.
  EXPECT_LT(errors_px.back(), 0.002);
  for (const auto& [id, point] : model->points) EXPECT_LT(point.error_px, 0.002);
}

TEST_F(ColmapModelTest, FollowsColmapsConventions) {
  ASSERT_TRUE(WriteColmapModel(MakeMap(), MakeSource(), folder_).ok());
  const auto model = testing::ReadColmapModel(folder_);
  ASSERT_TRUE(model.ok()) << model.status();
  const auto& camera = model->cameras.at(2);
  EXPECT_EQ(camera.width_px, 640);
  EXPECT_EQ(camera.fy_px, 601);
  EXPECT_EQ(camera.cx_px, 320.5);
  const auto& image = model->images.at(2);
  EXPECT_EQ(image.name, "bravo/1000000007.png");
  EXPECT_EQ(image.camera, 2);
  EXPECT_LT((image.camera_from_world.translation - Eigen::Vector3d(0.2, -0.1, 0.3)).norm(), 1e-9);
  EXPECT_NEAR(image.camera_from_world.rotation.w(), std::cos(0.05), 1e-9);
  EXPECT_EQ(image.keypoints.back().first, Eigen::Vector2d(5.5, 6.5));
  EXPECT_EQ(image.keypoints.back().second, -1);
  const Colour colour = ChooseColours({"alpha", "bravo"}).at("alpha");
  EXPECT_EQ(model->points.at(1).rgb, Eigen::Vector3i(colour.red, colour.green, colour.blue));
}

// Both robots rectified their pictures; alpha's lens needs COLMAP's full model.
TEST_F(ColmapModelTest, IsOfThePicturesAsTheyWereRecorded) {
  ColmapSource source = MakeSource();
  RecordedCamera& alpha = source.recorded[{kMapA, 0}];
  alpha.lens = {480, 482, 330, 236, RadialTangential{-0.2, 0.06, 0.001, -0.002, 0.01}};
  alpha.camera_from_recorded.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY());
  RecordedCamera& bravo = source.recorded[{kMapB, 0}];
  bravo.lens = {580, 582, 310, 246, RadialTangential{-0.1, 0.02, 0, 0.001, 0}};
  bravo.camera_from_recorded.rotation = Eigen::AngleAxisd(-0.02, Eigen::Vector3d::UnitX());
  ASSERT_TRUE(WriteColmapModel(MakeMap(), source, folder_).ok());
  const auto model = testing::ReadColmapModel(folder_);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->cameras.at(1).distortion,
            (std::vector<double>{-0.2, 0.06, 0.001, -0.002, 0.01, 0, 0, 0}));
  EXPECT_EQ(model->cameras.at(2).distortion, (std::vector<double>{-0.1, 0.02, 0, 0.001}));
  const std::vector<double> errors_px = testing::ReprojectionErrors_px(*model);
  ASSERT_EQ(errors_px.size(), 30u);
  EXPECT_LT(errors_px.back(), 0.003);
  // The keypoints are at other pixels than in the undistorted pictures.
  EXPECT_GT((model->images.at(1).keypoints.back().first - Eigen::Vector2d(5.5, 6.5)).norm(), 5);

  source.poses_of = PosesOf::kRectifiedCamera;
  ASSERT_TRUE(WriteColmapModel(MakeMap(), source, folder_).ok());
  const auto rectified = testing::ReadColmapModel(folder_);
  ASSERT_TRUE(rectified.ok()) << rectified.status();
  EXPECT_TRUE(rectified->cameras.at(1).distortion.empty());
  EXPECT_EQ(rectified->images.at(1).keypoints.back().first, Eigen::Vector2d(5.5, 6.5));
}

// A robot was started again on the same recording.
TEST_F(ColmapModelTest, GivesEachPictureANameOfItsOwn) {
  Map map = MakeMap();
  map.AddKeyframe(MakeKeyframe({kMapB, 0}, 500, Rigid3d(), 20, 1));
  ColmapSource source = MakeSource();
  source.robots[kMapB] = "alpha";
  source.numbers[kMapB] = 4;
  ASSERT_TRUE(WriteColmapModel(map, source, folder_).ok());
  const auto model = testing::ReadColmapModel(folder_);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->images.at(1).name, "alpha/1000000000.png");
  EXPECT_EQ(model->images.at(2).name, "alpha+4/1000000000.png");
  EXPECT_EQ(model->images.at(3).name, "alpha/1000000007.png");
}

// What became a part of another session is the robot's, too, and its camera's.
TEST_F(ColmapModelTest, PartsOfLocalMapsAreTheRobots) {
  map_store::MissionState state;
  const auto add = [&state](LocalMapId id, const char* agent) {
    map_store::LocalMapState& local_map = map_store::AddLocalMap(state, id, agent);
    local_map.cameras.push_back(std::make_shared<const Camera>());
    local_map.recorded_cameras.push_back(RecordedCamera());
  };
  // Ids are drawn: they say nothing of the order.
  add(LocalMapId{9}, "alpha");
  add(LocalMapId{5}, "bravo");
  add(LocalMapId{3}, "alpha");
  map_store::JoinedLocalMap part;
  part.id = LocalMapId{7};
  state.arrivals.Add(part.id, "alpha");
  state.local_maps[LocalMapId{3}].AddPart(part);
  const ColmapSource source = ColmapSourceOf(state, PosesOf::kRecordedCamera);
  EXPECT_EQ(source.robots.at(LocalMapId{7}), "alpha");
  EXPECT_EQ(source.numbers.at(LocalMapId{9}), 1u);
  EXPECT_EQ(source.numbers.at(LocalMapId{3}), 2u);
  EXPECT_EQ(source.numbers.at(LocalMapId{7}), 3u) << "a part keeps its number";
  EXPECT_EQ(source.numbers.at(LocalMapId{5}), 1u);
  EXPECT_EQ(source.recorded.count({LocalMapId{7}, 0}), 1u);
}

TEST_F(ColmapModelTest, SaysHowFarPointsAreOff) {
  Map map = MakeMap();
  map.SetPosition({kMapA, 3}, Place(3) + Eigen::Vector3d(0.05, 0, 0));
  ASSERT_TRUE(WriteColmapModel(map, {}, folder_).ok());
  const auto model = testing::ReadColmapModel(folder_);
  ASSERT_TRUE(model.ok()) << model.status();
  // The point is seen from the first camera alone, at a depth of 4.6.
  EXPECT_NEAR(model->points.at(4).error_px, 500 * 0.05 / 4.6, 0.01);
  EXPECT_NEAR(testing::ReprojectionErrors_px(*model).back(), 500 * 0.05 / 4.6, 0.01);
}

TEST_F(ColmapModelTest, SaysWhatItCantWrite) {
  EXPECT_THAT(std::string(WriteColmapModel(MakeMap(), {}, "/proc/none").status().message()),
              HasSubstr("/proc/none"));
}

TEST_F(ColmapModelTest, NeedsAKeyframe) {
  EXPECT_EQ(GlobalMapOf({}).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace corbslam::services

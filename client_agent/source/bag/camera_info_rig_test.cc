#include "client_agent/source/bag/camera_info_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "client_agent/source/bag/topic_names.h"

namespace corbslam::client_agent {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A bag's topics as tests name them; they live as long as the test.
class Topics {
 public:
  PictureTopic& Add(const std::string& name, const std::string& encoding,
                    const std::string& frame) {
    topics_.push_back(std::make_unique<BagTopic>());
    BagTopic& topic = *topics_.back();
    topic.name = name;
    topic.messages = 100;
    auto picture = std::make_unique<PictureTopic>();
    picture->topic = &topic;
    picture->base = BaseTopic(name);
    picture->is_compressed = picture->base != name;
    picture->form = {
        encoding, {640, 480}, encoding != "32FC1", encoding == "16UC1" || encoding == "32FC1"};
    picture->frame_id = frame;
    picture->is_depth = picture->form.can_be_depth && !SaysNoDepth(picture->base);
    pictures_.push_back(std::move(picture));
    return *pictures_.back();
  }
  std::vector<PictureTopic> all() const {
    std::vector<PictureTopic> all;
    for (const auto& picture : pictures_) all.push_back(*picture);
    return all;
  }

 private:
  std::vector<std::unique_ptr<BagTopic>> topics_;
  std::vector<std::unique_ptr<PictureTopic>> pictures_;
};

void Calibrate(PictureTopic& picture, double shift_px_m = 0) {
  RosCameraInfo info;
  info.width_px = 640;
  info.height_px = 480;
  info.distortion_model = "plumb_bob";
  info.k = {500, 0, 320, 0, 500, 240, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {500, 0, 320, shift_px_m, 0, 500, 240, 0, 0, 0, 1, 0};
  picture.info = info;
  picture.info_topic = picture.name() + "_info";
}

std::string ChosenOf(const absl::StatusOr<RigChoice>& choice) {
  if (!choice.ok()) return std::string(choice.status().message());
  return choice->first.name() + " " + choice->second.name();
}

std::string Chosen(const Topics& topics, const BagOptions& options = {}) {
  return ChosenOf(ChooseRig("b", topics.all(), TransformTree(), options, std::nullopt));
}

absl::StatusOr<CameraInfoRig> RigOf(const Topics& topics, const TransformTree& tree = {},
                                    const BagOptions& options = {}) {
  const auto choice = ChooseRig("b", topics.all(), tree, options, std::nullopt);
  if (!choice.ok()) return choice.status();
  return MakeCameraInfoRig("b", *choice, tree, options);
}

TransformTree Beside(const std::string& target, const std::string& source, double x, double y) {
  TransformTree tree;
  Rigid3d motion;
  motion.translation = {x, y, 0};
  tree.Add({target, source, motion});
  return tree;
}

TEST(RigChoiceTest, PairsAreFoundByTheirNames) {
  for (const auto& [left, right] :
       {std::pair("/left/image_raw", "/right/image_raw"),
        {"/cam0/image_raw", "/cam1/image_raw"},
        {"/camera/infra1/image_rect_raw", "/camera/infra2/image_rect_raw"},
        {"/zed/zed_node/left/image_rect_color", "/zed/zed_node/right/image_rect_color"},
        {"/kitti/image_02/image", "/kitti/image_03/image"},
        {"/left/image/compressed", "/right/image/compressed"}}) {
    Topics topics;
    topics.Add(right, "mono8", "r");
    topics.Add("/other/image_raw", "mono8", "o");
    topics.Add(left, "mono8", "l");
    EXPECT_EQ(Chosen(topics), std::string(left) + " " + right);
  }
}

TEST(RigChoiceTest, PairsAreFoundByTheirCalibration) {
  Topics topics;
  Calibrate(topics.Add("/front/a/image_raw", "mono8", "a"), -50);
  Calibrate(topics.Add("/front/b/image_raw", "mono8", "b"), 0);
  EXPECT_EQ(Chosen(topics), "/front/b/image_raw /front/a/image_raw");
}

TEST(RigChoiceTest, WhatIsCalibratedRawAndGreyGoesFirst) {
  Topics topics;
  topics.Add("/u/left/image_raw", "mono8", "");
  topics.Add("/u/right/image_raw", "mono8", "");
  Calibrate(topics.Add("/left/image_color", "rgb8", ""));
  Calibrate(topics.Add("/right/image_color", "rgb8", ""), -50);
  Calibrate(topics.Add("/left/image_raw/compressed", "mono8", ""));
  Calibrate(topics.Add("/right/image_raw/compressed", "mono8", ""), -50);
  Calibrate(topics.Add("/left/image_raw", "mono8", ""));
  Calibrate(topics.Add("/right/image_raw", "mono8", ""), -50);
  EXPECT_EQ(Chosen(topics), "/left/image_raw /right/image_raw");
}

TEST(RigChoiceTest, DepthGoesWithThePictureInItsFrame) {
  Topics topics;
  Calibrate(topics.Add("/camera/color/image_raw", "rgb8", "color"));
  Calibrate(topics.Add("/camera/infra1/image_rect_raw", "mono8", "depth"));
  Calibrate(topics.Add("/camera/depth/image_rect_raw", "16UC1", "depth"));
  EXPECT_EQ(Chosen(topics), "/camera/infra1/image_rect_raw /camera/depth/image_rect_raw");
  Calibrate(topics.Add("/camera/aligned_depth_to_color/image_raw", "16UC1", "color"));
  BagOptions options;
  options.left = "/camera/color/image_raw";
  EXPECT_EQ(Chosen(topics, options),
            "/camera/color/image_raw /camera/aligned_depth_to_color/image_raw");
}

TEST(RigChoiceTest, ASingleCameraIsNoRig) {
  Topics topics;
  topics.Add("/usb_cam/image_raw", "rgb8", "usb");
  EXPECT_THAT(Chosen(topics), AllOf(HasSubstr("/usb_cam/image_raw (rgb8, 640x480)"),
                                    HasSubstr("A single camera is not played")));
  EXPECT_THAT(Chosen(Topics()), HasSubstr("no pictures"));
}

TEST(CameraInfoRigTest, AnIdealPairIsRectified) {
  Topics topics;
  Calibrate(topics.Add("/left/image_raw", "mono8", "l"));
  Calibrate(topics.Add("/right/image_raw", "mono8", "r"), -50);
  const auto made = RigOf(topics);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_TRUE(made->rig.rectified);
  EXPECT_DOUBLE_EQ(made->rig.baseline_m, 0.1);
}

TEST(CameraInfoRigTest, ALensThatBendsIsRectifiedHere) {
  Topics topics;
  for (const char* side : {"left", "right"}) {
    PictureTopic& picture = topics.Add(std::string("/") + side + "/image_raw", "mono8", side);
    Calibrate(picture, side == std::string("left") ? 0 : -50);
    picture.info->d = {-0.3, 0.1, 0.001, 0.002, 0};
    picture.info->p[0] = picture.info->p[5] = 400;
  }
  const auto made = RigOf(topics);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_FALSE(made->rig.rectified);
  EXPECT_EQ(made->rig.cameras[0].raw.fx_px, 500);
  EXPECT_EQ(std::get<RadialTangential>(made->rig.cameras[1].raw.lens).k1, -0.3);
  EXPECT_NEAR(made->rig.right_from_left.translation.x(), -50. / 400, 1e-12);
}

TEST(CameraInfoRigTest, RectifiedTopicsArePsPinholes) {
  Topics topics;
  for (const char* side : {"left", "right"}) {
    PictureTopic& picture = topics.Add(std::string("/") + side + "/image_rect", "mono8", side);
    Calibrate(picture, side == std::string("left") ? 0 : -50);
    picture.info->d = {-0.3, 0.1, 0.001, 0.002, 0};
    picture.info->p[0] = picture.info->p[5] = 400;
  }
  const auto made = RigOf(topics);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_TRUE(made->rig.rectified);
  EXPECT_EQ(made->rig.cameras[0].raw.fx_px, 400);
  EXPECT_DOUBLE_EQ(made->rig.baseline_m, 0.125);
}

TEST(CameraInfoRigTest, WithoutABaselineInPTheFramesSayIt) {
  Topics topics;
  Calibrate(topics.Add("/left/image_raw", "mono8", "l"));
  Calibrate(topics.Add("/right/image_raw", "mono8", "r"));
  auto made = RigOf(topics, Beside("l", "r", 0.2, 0));
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_TRUE(made->rig.rectified);
  EXPECT_DOUBLE_EQ(made->rig.baseline_m, 0.2);
  made = RigOf(topics, Beside("l", "r", 0.2, 0.1));
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_FALSE(made->rig.rectified);
  EXPECT_DOUBLE_EQ(made->rig.right_from_left.translation.y(), -0.1);
  EXPECT_THAT(RigOf(topics).status().message(),
              AllOf(HasSubstr("has no baseline"), HasSubstr("no /tf_static from frame 'l'")));
}

TEST(CameraInfoRigTest, ASmallerPictureIsExplainedOrRefused) {
  Topics topics;
  for (const char* side : {"left", "right"}) {
    PictureTopic& picture = topics.Add(std::string("/") + side + "/image_raw", "mono8", side);
    Calibrate(picture, side == std::string("left") ? 0 : -50);
    picture.form.size = {320, 240};
    picture.info->binning_x = picture.info->binning_y = 2;
  }
  const auto made = RigOf(topics);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->rig.cameras[0].raw.fx_px, 250);
  EXPECT_EQ(made->rig.cameras[1].raw.cx_px, 160);
  Topics odd;
  Calibrate(odd.Add("/left/image_raw", "mono8", "l"));
  Calibrate(odd.Add("/right/image_raw", "mono8", "r"), -50);
  std::vector<PictureTopic> pictures = odd.all();
  for (PictureTopic& picture : pictures) picture.form.size = {320, 240};
  const auto choice = ChooseRig("b", pictures, {}, {}, std::nullopt);
  ASSERT_TRUE(choice.ok());
  EXPECT_THAT(
      MakeCameraInfoRig("b", *choice, {}, {}).status().message(),
      AllOf(HasSubstr("/left/image_raw_info"), HasSubstr("640, 480"), HasSubstr("320x240")));
}

TEST(CameraInfoRigTest, WhatWasNotCalibratedIsNamed) {
  Topics topics;
  topics.Add("/left/image_raw", "mono8", "l");
  topics.Add("/right/image_raw", "mono8", "r");
  EXPECT_THAT(RigOf(topics).status().message(),
              AllOf(HasSubstr("/left/image_raw has no CameraInfo"), HasSubstr("?rig=FILE")));
  Topics zeros;
  for (const char* side : {"left", "right"}) {
    PictureTopic& picture = zeros.Add(std::string("/") + side + "/image_raw", "mono8", side);
    Calibrate(picture);
    picture.info->k = {};
  }
  EXPECT_THAT(RigOf(zeros, Beside("left", "right", 0.2, 0)).status().message(),
              HasSubstr("was this camera calibrated?"));
}

TEST(CameraInfoRigTest, DepthOfItsOwnCameraNeedsTheFrames) {
  Topics topics;
  Calibrate(topics.Add("/camera/color/image_raw", "rgb8", "colour"));
  Calibrate(topics.Add("/camera/depth/image_raw", "16UC1", "depth"));
  const auto made = RigOf(topics, Beside("colour", "depth", -0.02, 0));
  ASSERT_TRUE(made.ok()) << made.status();
  ASSERT_TRUE(made->rig.depth.camera.has_value());
  EXPECT_EQ(made->rig.depth.colour_from_depth.translation.x(), -0.02);
  EXPECT_THAT(RigOf(topics).status().message(), HasSubstr("is not registered to"));
  BagOptions options;
  options.registers = false;
  options.depth_units_per_m = 5000;
  const auto registered = RigOf(topics, {}, options);
  ASSERT_TRUE(registered.ok()) << registered.status();
  EXPECT_FALSE(registered->rig.depth.camera.has_value());
  EXPECT_EQ(registered->rig.depth.units_per_m, 5000);
}

}  // namespace
}  // namespace corbslam::client_agent

#include "client_agent/agent/picture_maker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "client_agent/agent/agent.h"
#include "client_agent/link/testing/fake_uplink.h"

namespace corbslam::client_agent {
namespace {

SensorCalibration Calibration() {
  StereoCalibration stereo;
  stereo.camera = {.fx_px = 400,
                   .fy_px = 400,
                   .cx_px = 320,
                   .cy_px = 240,
                   .width_px = 640,
                   .height_px = 480,
                   .baseline_m = 0.2,
                   .close_depth_m = 8};
  return stereo;
}

TEST(PictureMakerTest, MakesWhatItIsGivenAndEndsWithWorkLeft) {
  std::vector<uint32_t> made;
  absl::Mutex mutex;
  const cv::Mat grey(480, 640, CV_8UC1, cv::Scalar(70));
  {
    PictureMaker maker(Calibration(), 320, [&](const KeyframePicture& picture) {
      absl::MutexLock lock(&mutex);
      EXPECT_FALSE(picture.jpeg.empty());
      EXPECT_EQ(picture.scale, 2);
      made.push_back(picture.keyframe.index);
    });
    for (uint32_t index = 0; index < 3; ++index) maker.Add({{1}, index}, grey);
    maker.Finish();
    absl::MutexLock lock(&mutex);
    EXPECT_EQ(made, (std::vector<uint32_t>{0, 1, 2}));
  }
  PictureMaker slow(Calibration(), 320,
                    [](const KeyframePicture&) { absl::SleepFor(absl::Milliseconds(50)); });
  for (uint32_t index = 0; index < 1000; ++index) slow.Add({{1}, index}, grey);
}

// An impossible calibration, or a picture of another size, ends nothing.
TEST(PictureMakerTest, WhatCannotBeMadeIsLeftOut) {
  int made = 0;
  RgbdCalibration impossible;
  PictureMaker none(impossible, 320, [&](const KeyframePicture&) { ++made; });
  none.Add({{1}, 1}, cv::Mat(480, 640, CV_8UC1, cv::Scalar(70)));
  none.Finish();
  PictureMaker maker(Calibration(), 320, [&](const KeyframePicture&) { ++made; });
  maker.Add({{1}, 1}, cv::Mat());
  maker.Finish();
  EXPECT_EQ(made, 0);
}

// A robot that drives along a wall.
class PicturedAgentTest : public ::testing::Test {
 protected:
  static constexpr int kStep_px = 32;
  static constexpr int kFrames = 40;

  PicturedAgentTest() {
    cv::Mat coarse(120, (640 + kFrames * kStep_px + 100) / 4, CV_8UC1);
    cv::RNG(5).fill(coarse, cv::RNG::UNIFORM, 0, 256);
    cv::resize(coarse, wall_, cv::Size(), 4, 4, cv::INTER_CUBIC);
    uplink_.capabilities.keyframe_pictures = true;
  }
  void Drive(AgentOptions options) {
    options.sensor.orb.features = 1000;
    const auto vocabulary =
        *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
    const auto agent = *Agent::Create(options, Calibration(), vocabulary, &uplink_);
    for (int i = 0; i < kFrames; ++i) {
      SensorImages images{.timestamp_ns = i * int64_t{100'000'000}};
      images.grey = wall_(cv::Rect(i * kStep_px, 0, 640, 480));
      images.right = wall_(cv::Rect(i * kStep_px + 20, 0, 640, 480));
      ASSERT_TRUE(agent->Track(images).ok());
      if (!options.deterministic) absl::SleepFor(absl::Milliseconds(5));
    }
    ASSERT_TRUE(agent->Finish(absl::Seconds(60)).ok());
  }

  cv::Mat wall_;
  FakeUplink uplink_;
};

TEST_F(PicturedAgentTest, EveryKeyframeThatGoesUpHasItsPicture) {
  AgentOptions options;
  options.picture_width_px = 320;
  Drive(options);
  std::set<KeyframeId> told;
  for (const auto& [id, batches] : uplink_.stored) {
    for (const MapUpdateBatch& batch : batches) {
      for (const FullKeyframe& keyframe : batch.full_keyframes) told.insert(keyframe.payload->id);
    }
  }
  std::set<KeyframeId> pictured;
  for (const KeyframePicture& picture : uplink_.pictures) {
    EXPECT_TRUE(told.contains(picture.keyframe));
    EXPECT_TRUE(pictured.insert(picture.keyframe).second) << "sent twice";
  }
  EXPECT_GT(told.size(), 3u);
  // Where the machine is busy, some may be left out.
  EXPECT_GE(pictured.size() + 2, told.size());
}

TEST_F(PicturedAgentTest, ADeterministicRobotAndOneThatIsToldSoSendNone) {
  AgentOptions options;
  options.picture_width_px = 320;
  options.deterministic = true;
  Drive(options);
  EXPECT_TRUE(uplink_.pictures.empty());
  options.deterministic = false;
  options.picture_width_px = 0;
  options.seed = 2;
  Drive(options);
  EXPECT_TRUE(uplink_.pictures.empty());
}

}  // namespace
}  // namespace corbslam::client_agent

// Tests the whole robot on recorded images (CORBSLAM_DATA_DIR), and what of it needs none.
#include "client_agent/agent/agent.h"

#include <glog/logging.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "client_agent/source/recorded_sequence.h"

namespace corbslam::client_agent {
namespace {

std::shared_ptr<const Vocabulary> ShippedVocabulary() {
  return *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
}

SensorCalibration TestCalibration() {
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

TEST(AgentTest, RefusesImpossibleOptions) {
  AgentOptions options;
  options.name = "";
  EXPECT_TRUE(absl::IsInvalidArgument(
      Agent::Create(options, TestCalibration(), ShippedVocabulary(), nullptr).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(
      Agent::Create(AgentOptions(), TestCalibration(), nullptr, nullptr).status()));
  StereoCalibration broken = std::get<StereoCalibration>(TestCalibration());
  broken.camera.fx_px = -1;
  EXPECT_TRUE(absl::IsInvalidArgument(
      Agent::Create(AgentOptions(), broken, ShippedVocabulary(), nullptr).status()));
}

TEST(AgentTest, BlackImagesAreNoErrorAndWrongOnesAre) {
  auto agent = Agent::Create(AgentOptions(), TestCalibration(), ShippedVocabulary(), nullptr);
  ASSERT_TRUE(agent.ok()) << agent.status();
  const cv::Mat black = cv::Mat::zeros(480, 640, CV_8UC1);
  const auto result = (*agent)->Track({1, black, black, cv::Mat()});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->state, TrackingState::kNotInitialised);
  EXPECT_FALSE((*agent)->Track({2, cv::Mat(), cv::Mat(), cv::Mat()}).ok());
  EXPECT_FALSE((*agent)->GetNearMap({}).has_value()) << "it knows no place";
  EXPECT_TRUE((*agent)->Finish(absl::Seconds(10)).ok());
  EXPECT_EQ((*agent)->GetStatus().frames, 1);
}

class WatchLog : public google::LogSink {
 public:
  WatchLog() { google::AddLogSink(this); }
  ~WatchLog() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity, const char*, const char*, int, const struct ::tm*,
            const char* message, size_t length) override {
    const absl::string_view line(message, length);
    told += absl::StrContains(line, "kim: stereo points are") &&
                    absl::StrContains(line, "[stereo-points-few]")
                ? 1
                : 0;
  }
  int told = 0;
};

// A live robot has no end at which somebody could read what its sensor found.
TEST(AgentTest, WhatTheSensorFindsIsLoggedWhenItIsFound) {
  AgentOptions options;
  options.name = "kim";
  options.deterministic = true;
  options.sensor.orb.features = 300;
  auto agent = Agent::Create(options, TestCalibration(), ShippedVocabulary(), nullptr);
  ASSERT_TRUE(agent.ok()) << agent.status();
  cv::Mat left(480, 640, CV_8UC1);
  cv::RNG(5).fill(left, cv::RNG::UNIFORM, 0, 256);
  cv::resize(left(cv::Rect(0, 0, 160, 120)), left, left.size(), 0, 0, cv::INTER_CUBIC);
  const cv::Mat covered(480, 640, CV_8UC1, cv::Scalar(9));
  WatchLog log;
  for (int64_t i = 1; i <= 60; ++i) {
    EXPECT_EQ(log.told, i <= 50 ? 0 : 1) << i;
    ASSERT_TRUE((*agent)->Track({i * 100'000'000, left, covered, cv::Mat()}).ok());
  }
  EXPECT_EQ((*agent)->GetStatus().input_findings.size(), 1u);
}

class RecordedAgentTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("CORBSLAM_DATA_DIR");
    if (folder == nullptr) {
      ASSERT_EQ(std::getenv("CI"), nullptr) << "CORBSLAM_DATA_DIR must be set";
      GTEST_SKIP() << "CORBSLAM_DATA_DIR is not set";
    }
    source_ = "tum:" + std::string(folder) + "/tum_fr1_xyz_15hz";
  }

  std::unique_ptr<Agent> Open(bool deterministic) {
    source_images_ = *OpenSource(source_ + "?frames=0:59");
    AgentOptions options;
    options.deterministic = deterministic;
    options.sensor.orb.features = 1000;
    return *Agent::Create(options, source_images_->calibration(), ShippedVocabulary(), nullptr);
  }

  // Plays up to `count` frames; the images are kept.
  void Play(Agent& agent, int count) {
    for (int i = 0; i < count; ++i) {
      const auto images = source_images_->NextImages();
      ASSERT_TRUE(images.ok()) << images.status();
      if (!images->has_value()) return;
      played_.push_back(**images);
      ASSERT_TRUE(agent.Track(played_.back()).ok());
    }
  }

  SensorImages Black() const {
    SensorImages black = played_.back();
    black.grey = cv::Mat::zeros(black.grey.size(), black.grey.type());
    black.depth = cv::Mat::zeros(black.depth.size(), black.depth.type());
    return black;
  }

  // A good picture of a place that nobody has seen.
  SensorImages Elsewhere() const {
    SensorImages other = played_.back();
    cv::RNG random(5);
    other.grey = cv::Mat(other.grey.size(), other.grey.type());
    random.fill(other.grey, cv::RNG::UNIFORM, 0, 256);
    cv::resize(other.grey(cv::Rect(0, 0, other.grey.cols / 4, other.grey.rows / 4)), other.grey,
               other.grey.size(), 0, 0, cv::INTER_CUBIC);
    other.depth = cv::Mat(other.depth.size(), other.depth.type(), cv::Scalar(10'000));
    return other;
  }

  std::string source_;
  std::unique_ptr<RecordedSequence> source_images_;
  std::vector<SensorImages> played_;
};

TEST_F(RecordedAgentTest, DeterministicRunsAreTheSameToTheBit) {
  const auto run = [this] {
    std::unique_ptr<Agent> agent = Open(/*deterministic=*/true);
    Play(*agent, 60);
    EXPECT_TRUE(agent->Finish(absl::Seconds(60)).ok());
    return agent;
  };
  const std::unique_ptr<Agent> first = run();
  const std::unique_ptr<Agent> second = run();
  const auto a = first->LocalTrajectory();
  const auto b = second->LocalTrajectory();
  ASSERT_EQ(a.size(), 60u);
  ASSERT_EQ(b.size(), a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].local_map, b[i].local_map);
    EXPECT_EQ(a[i].local_from_camera.translation, b[i].local_from_camera.translation);
    EXPECT_EQ(a[i].local_from_camera.rotation.coeffs(), b[i].local_from_camera.rotation.coeffs());
  }
  const Map map_a = first->CopyMap();
  const Map map_b = second->CopyMap();
  ASSERT_EQ(map_a.points().size(), map_b.points().size());
  for (const auto& [id, point] : map_a.points()) {
    ASSERT_NE(map_b.FindPoint(id), nullptr);
    EXPECT_EQ(point.position_in_map, map_b.FindPoint(id)->position_in_map);
    EXPECT_EQ(point.observations, map_b.FindPoint(id)->observations);
  }
}

TEST_F(RecordedAgentTest, PatchesAreFollowedBetweenKeyframesAndSearchedForFeaturesAfterwards) {
  std::unique_ptr<Agent> agent = Open(/*deterministic=*/false);
  int followed = 0;
  int follow_keyframes = 0;
  for (int i = 0; i < 60; ++i) {
    const auto images = source_images_->NextImages();
    ASSERT_TRUE(images.ok() && images->has_value());
    const auto result = agent->Track(**images);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->state, TrackingState::kTracking) << i;
    followed += result->was_followed;
    follow_keyframes += result->follows_keyframe;
    EXPECT_FALSE(result->was_followed && result->made_keyframe) << "its features come later";
    // The first keyframe's points are made beside tracking.
    if (i > 2) {
      EXPECT_GT(result->points_matched, 50);
    }
    EXPECT_GE(result->points_in_view, result->points_matched);
    ASSERT_TRUE(agent->UsePause().ok());
    ASSERT_TRUE(agent->UsePause().ok()) << "there is nothing left to do";
  }
  EXPECT_GT(followed, 20);
  EXPECT_GT(follow_keyframes, 0);
  ASSERT_TRUE(agent->Finish(absl::Seconds(60)).ok());
  const Map map = agent->CopyMap();
  for (const auto& [id, keyframe] : map.keyframes()) {
    EXPECT_GT(keyframe.keypoints().size(), 900u) << ToString(id);
  }
}

TEST_F(RecordedAgentTest, FramesThatComeSeldomAreNotFollowed) {
  std::unique_ptr<Agent> agent = Open(/*deterministic=*/true);
  for (int i = 0; i < 20; ++i) {
    auto images = source_images_->NextImages();
    ASSERT_TRUE(images.ok() && images->has_value()) << images.status();
    (*images)->timestamp_ns = int64_t{200'000'000} * (1 + i);
    const auto result = agent->Track(**images);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->state, TrackingState::kTracking) << i;
    EXPECT_FALSE(result->was_followed) << i;
  }
}

TEST_F(RecordedAgentTest, ThreadedRunTracksEveryFrame) {
  std::unique_ptr<Agent> agent = Open(/*deterministic=*/false);
  Play(*agent, 60);
  ASSERT_TRUE(agent->Finish(absl::Seconds(60)).ok());
  const AgentStatus status = agent->GetStatus();
  EXPECT_EQ(status.tracked, 60);
  EXPECT_EQ(agent->LocalTrajectory().size(), 60u);
  EXPECT_GE(status.keyframes, 3);
  EXPECT_GT(status.map_points, 500);
  const auto near = agent->GetNearMap({.radius_m = 100, .max_points = 400});
  ASSERT_TRUE(near.has_value());
  EXPECT_EQ(near->local_map, status.local_map);
  EXPECT_EQ(near->timestamp_ns, status.timestamp_ns);
  EXPECT_EQ(near->own_points.size(), 400u);
  EXPECT_TRUE(near->truncated);
  EXPECT_EQ(near->keyframes.size(), static_cast<size_t>(status.keyframes));
  EXPECT_LT((near->centre - status.local_from_camera.translation).norm(), 1e-9);
}

TEST_F(RecordedAgentTest, LostForAWhileItFindsBackLostForLongItOpensANewMap) {
  std::unique_ptr<Agent> agent = Open(/*deterministic=*/true);
  Play(*agent, 60);
  const LocalMapId first = agent->GetStatus().local_map;
  ASSERT_GE(agent->GetStatus().keyframes, 5) << "too small a map to wait in";
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(agent->Track(Black())->state, TrackingState::kLost);
  }
  EXPECT_EQ(agent->Track(played_[30])->state, TrackingState::kTracking);
  EXPECT_EQ(agent->GetStatus().local_map, first);

  for (int i = 0; i < 40; ++i) ASSERT_TRUE(agent->Track(Black()).ok());
  EXPECT_EQ(agent->GetStatus().local_maps, 1) << "what covers the camera ends no map";
  EXPECT_EQ(agent->GetStatus().why_no_pose, WhyNoPose::kFewKeypoints);
  for (int i = 0; i < 16; ++i) ASSERT_TRUE(agent->Track(Elsewhere()).ok());
  EXPECT_EQ(agent->GetStatus().local_maps, 2);
  EXPECT_EQ(agent->Track(played_[10])->state, TrackingState::kTracking);
  EXPECT_EQ(agent->Track(played_[11])->state, TrackingState::kTracking);
  EXPECT_NE(agent->GetStatus().local_map, first);
  // The first map's frames are still there.
  const auto trajectory = agent->LocalTrajectory();
  EXPECT_EQ(trajectory.size(), 63u);
  EXPECT_EQ(trajectory.front().local_map, first);
  EXPECT_NE(trajectory.back().local_map, first);
  EXPECT_TRUE(agent->Finish(absl::Seconds(60)).ok());
}

}  // namespace
}  // namespace corbslam::client_agent

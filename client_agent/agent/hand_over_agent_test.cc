// Tests a robot whose map is bounded: it drives along a wall, and tells a simulated map store.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "client_agent/agent/agent.h"
#include "client_agent/link/testing/fake_uplink.h"
#include "client_agent/spool/testing/fake_spool.h"

namespace corbslam::client_agent {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;
constexpr int kStep_px = 32;
constexpr int kFrames = 150;
constexpr double kDepth_m = 4;
constexpr int64_t kFrame_ns = 100'000'000;
// Metres that the camera moves along x from frame to frame.
constexpr double kStep_m = kStep_px * kDepth_m / 400;
// What estimates may have drifted after the whole way, a hundredth of it.
constexpr double kDrift_m = 0.01 * kFrames * kStep_m;

SensorCalibration Calibration() {
  StereoCalibration stereo;
  stereo.camera = {.fx_px = 400,
                   .fy_px = 400,
                   .cx_px = 320,
                   .cy_px = 240,
                   .width_px = kWidth_px,
                   .height_px = kHeight_px,
                   .baseline_m = 0.2,
                   .close_depth_m = 8};
  return stereo;
}

// A wall that is as far away everywhere, so that pictures of it are parts of one long picture.
cv::Mat MakeWall() {
  cv::RNG random(5);
  cv::Mat coarse(kHeight_px / 4, (kWidth_px + kFrames * kStep_px + 100) / 4, CV_8UC1);
  random.fill(coarse, cv::RNG::UNIFORM, 0, 256);
  cv::Mat wall;
  cv::resize(coarse, wall, cv::Size(), 4, 4, cv::INTER_CUBIC);
  return wall;
}

class HandOverAgentTest : public ::testing::Test {
 protected:
  std::unique_ptr<Agent> Make(AgentOptions options) {
    options.deterministic = true;
    options.sensor.orb.features = 1000;
    auto vocabulary =
        *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
    return *Agent::Create(options, Calibration(), vocabulary, &uplink_);
  }

  SensorImages ImagesOf(int frame) const {
    const int disparity_px = static_cast<int>(400 * 0.2 / kDepth_m);
    const auto part = [&](int x) { return wall_(cv::Rect(x, 0, kWidth_px, kHeight_px)).clone(); };
    const int x = frame * kStep_px;
    return {frame * kFrame_ns, part(x), part(x + disparity_px), cv::Mat()};
  }

  TrackingResult Track(Agent& agent, int frame) {
    const auto result = agent.Track(ImagesOf(frame));
    EXPECT_TRUE(result.ok()) << result.status();
    return *result;
  }

  int KeyframesAtStore() const {
    int keyframes = 0;
    for (const auto& [id, batches] : uplink_.stored) {
      for (const MapUpdateBatch& batch : batches) {
        keyframes += static_cast<int>(batch.full_keyframes.size());
        keyframes -= static_cast<int>(batch.removed_keyframes.size());
      }
    }
    return keyframes;
  }

  const cv::Mat wall_ = MakeWall();
  FakeUplink uplink_;
};

AgentOptions Bounded(uint64_t max_map_bytes) {
  AgentOptions options;
  options.max_map_bytes = max_map_bytes;
  return options;
}

constexpr uint64_t kFewBytes = 2 << 20;

TEST_F(HandOverAgentTest, PosesGoOnWithoutALostFrameOrAJump) {
  const std::unique_ptr<Agent> agent = Make(Bounded(kFewBytes));
  std::set<LocalMapId> local_maps;
  Rigid3d before;
  for (int i = 0; i < kFrames; ++i) {
    const TrackingResult result = Track(*agent, i);
    ASSERT_EQ(result.state, TrackingState::kTracking) << i;
    EXPECT_EQ(result.epoch, 1u) << i;
    local_maps.insert(result.local_map);
    const Rigid3d now = result.camera_from_local.Inverse();
    ASSERT_TRUE(result.odom_from_camera.has_value());
    EXPECT_NEAR(result.odom_from_camera->translation.x(), i * kStep_m, kDrift_m) << i;
    if (i > 0) {
      const Eigen::Vector3d step = now.translation - before.translation;
      EXPECT_LT((step - Eigen::Vector3d(kStep_m, 0, 0)).norm(), 0.03) << i;
      ASSERT_TRUE(result.motion.has_value()) << i;
      EXPECT_EQ(result.motion->since_ns, kFrame_ns) << i;
    }
    before = now;
  }
  const AgentStatus status = agent->GetStatus();
  EXPECT_GE(status.hand_overs, 2);
  EXPECT_EQ(status.local_maps, status.hand_overs + 1);
  EXPECT_EQ(local_maps.size(), static_cast<size_t>(status.local_maps));
  EXPECT_EQ(status.lost, 0);
  EXPECT_EQ(status.tracked, kFrames);
}

TEST_F(HandOverAgentTest, WhatLeavesMemoryIsAtTheStoreAndCounts) {
  const std::unique_ptr<Agent> agent = Make(Bounded(kFewBytes));
  uint64_t most_bytes = 0;
  for (int i = 0; i < kFrames; ++i) {
    Track(*agent, i);
    most_bytes = std::max(most_bytes, agent->GetStatus().map_bytes);
  }
  const Map map = agent->CopyMap();
  ASSERT_TRUE(agent->Finish(absl::Seconds(60)).ok());
  const AgentStatus status = agent->GetStatus();
  ASSERT_GE(status.hand_overs, 1);
  EXPECT_GT(most_bytes, kFewBytes) << "it ends when it is full";
  EXPECT_LT(static_cast<int>(map.keyframes().size()), status.keyframes)
      << "the map in use is the last part";
  EXPECT_EQ(KeyframesAtStore(), status.keyframes);
  ASSERT_EQ(uplink_.stored.size(), static_cast<size_t>(status.local_maps));
  for (const auto& [id, batches] : uplink_.stored) {
    ASSERT_FALSE(batches.empty());
    EXPECT_TRUE(batches.back().closes_local_map);
  }
  const std::vector<TrajectoryPose> trajectory = agent->LocalTrajectory();
  ASSERT_EQ(trajectory.size(), static_cast<size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    const TrajectoryPose& pose = trajectory[static_cast<size_t>(i)];
    EXPECT_EQ(pose.timestamp_ns, i * kFrame_ns);
    EXPECT_NEAR(pose.local_from_camera.translation.x(), i * kStep_m, kDrift_m) << i;
  }
}

TEST_F(HandOverAgentTest, TheNewLocalMapLiesWhereTheOldOneDidUntilTheStoreSaysOtherwise) {
  const std::unique_ptr<Agent> agent = Make(Bounded(kFewBytes));
  const auto place = [&](double x) {
    SharedUpdate update;
    update.restart = true;
    update.global_from_local =
        Similarity3d::FromRigid({Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0, 0)});
    uplink_.Share(update);
  };
  int i = 0;
  for (; i < 5; ++i) Track(*agent, i);
  EXPECT_FALSE(agent->GetStatus().global_from_local.has_value());
  place(100);
  Track(*agent, i++);
  ASSERT_TRUE(agent->GetStatus().global_from_local.has_value());
  while (i < kFrames && agent->GetStatus().hand_overs == 0) Track(*agent, i++);
  ASSERT_EQ(agent->GetStatus().hand_overs, 1);
  Track(*agent, i++);
  ASSERT_TRUE(agent->GetStatus().global_from_local.has_value());
  EXPECT_EQ(agent->GetStatus().global_from_local->translation.x(), 100);
  place(101);
  Track(*agent, i++);
  ASSERT_TRUE(agent->GetStatus().global_from_local.has_value());
  EXPECT_EQ(agent->GetStatus().global_from_local->translation.x(), 101);
  EXPECT_EQ(agent->GetStatus().global_from_local->translation.x(), 101);
  SharedUpdate apart;
  apart.restart = true;
  apart.apart = true;
  uplink_.Share(apart);
  Track(*agent, i++);
  EXPECT_FALSE(agent->GetStatus().global_from_local.has_value())
      << "the store has said it, and takes it back";
  agent->BeginLocalMap();
  Track(*agent, i++);
  EXPECT_FALSE(agent->GetStatus().global_from_local.has_value());
}

TEST_F(HandOverAgentTest, ALocalMapThatIsBegunAnewInheritsNoPlace) {
  const std::unique_ptr<Agent> agent = Make(Bounded(kFewBytes));
  for (int i = 0; i < 5; ++i) Track(*agent, i);
  SharedUpdate update;
  update.global_from_local = Similarity3d::Identity();
  uplink_.Share(update);
  Track(*agent, 5);
  ASSERT_TRUE(agent->GetStatus().global_from_local.has_value());
  agent->BeginLocalMap();
  EXPECT_EQ(Track(*agent, 6).epoch, 2u);
  EXPECT_FALSE(agent->GetStatus().global_from_local.has_value());
  EXPECT_EQ(agent->GetStatus().hand_overs, 0);
}

TEST_F(HandOverAgentTest, NothingLeavesMemoryBeforeItIsSafe) {
  uplink_.acknowledge = false;
  AgentOptions options = Bounded(kFewBytes);
  options.max_outbox_bytes = 1 << 16;
  const std::unique_ptr<Agent> agent = Make(options);
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_EQ(Track(*agent, i).state, TrackingState::kTracking) << i;
  }
  AgentStatus status = agent->GetStatus();
  EXPECT_EQ(status.local_maps, 1) << "the map waits in memory, whole";
  EXPECT_GT(status.map_bytes, 2 * kFewBytes);
  EXPECT_EQ(agent->CopyMap().keyframes().size(), static_cast<size_t>(status.keyframes));
  // The store says in the next session what it has.
  uplink_.acknowledge = true;
  uplink_.Break(absl::UnavailableError("cut"));
  absl::SleepFor(absl::Milliseconds(500));
  for (int i = kFrames - 1; i > kFrames - 20; --i) Track(*agent, i);
  EXPECT_EQ(agent->GetStatus().hand_overs, 1);
  EXPECT_LT(agent->GetStatus().map_bytes, status.map_bytes / 2);
}

// Drives to the wall's end and back, with a disk and without a map store.
class FarAgentTest : public HandOverAgentTest {
 protected:
  static constexpr uint64_t kMapBytes = 4 << 20;

  std::unique_ptr<Agent> MakeWithDisk() {
    AgentOptions options = Bounded(kMapBytes);
    options.deterministic = true;
    options.sensor.orb.features = 1000;
    options.spool_within = absl::Seconds(1);
    options.share.radius_m = 6;
    // Little waits in memory: what comes back is read from the disk.
    options.max_outbox_bytes = 1 << 16;
    auto vocabulary =
        *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
    return *Agent::Create(options, Calibration(), vocabulary, nullptr, *OpenFakeSpool(&disk_));
  }
  void DriveOut(Agent& agent) {
    for (int i = 0; i < kFrames; ++i) {
      ASSERT_EQ(Track(agent, i).state, TrackingState::kTracking) << i;
    }
    ASSERT_GE(agent.GetStatus().hand_overs, 1);
  }
  void DriveBack(Agent& agent, int frames) {
    for (int i = 1; i < frames; ++i) {
      SensorImages images = ImagesOf(kFrames - 1 - i);
      images.timestamp_ns = (kFrames + i) * kFrame_ns;
      const auto result = agent.Track(images);
      ASSERT_TRUE(result.ok()) << result.status();
      ASSERT_EQ(result->state, TrackingState::kTracking) << i;
      EXPECT_NEAR(result->camera_from_local.Inverse().translation.x(), (kFrames - 1 - i) * kStep_m,
                  2 * kDrift_m);
      most_bytes_ = std::max(most_bytes_, agent.GetStatus().map_bytes);
    }
  }

  FakeDisk disk_;
  uint64_t most_bytes_ = 0;
};

TEST_F(FarAgentTest, WithoutAStoreWhatItPassesAgainComesBackFromTheDisk) {
  const std::unique_ptr<Agent> agent = MakeWithDisk();
  DriveOut(*agent);
  const uint64_t brought_on_the_way_out = agent->GetStatus().far.brought_back;
  DriveBack(*agent, kFrames);
  const AgentStatus status = agent->GetStatus();
  EXPECT_GT(status.far.brought_back, brought_on_the_way_out + 5);
  EXPECT_GT(status.foreign_keyframes, 0);
  EXPECT_GT(status.foreign_points_percent, 5);
  EXPECT_EQ(status.far.unreadable, 0u);
  EXPECT_LT(most_bytes_, 2 * kMapBytes);
  EXPECT_FALSE(status.global_from_local.has_value()) << "there is no global frame";
}

TEST_F(FarAgentTest, ADamagedDiskEndsNoRobot) {
  const std::unique_ptr<Agent> agent = MakeWithDisk();
  DriveOut(*agent);
  for (auto& [name, content] : disk_.files) {
    for (size_t i = content.size() / 10; i < content.size(); i += 1000) content[i] ^= 0x55;
  }
  DriveBack(*agent, kFrames / 2);
  EXPECT_GT(agent->GetStatus().far.unreadable, 0u);
  EXPECT_EQ(agent->GetStatus().lost, 0);
}

// None means none: neither what others made nor where the robot is.
TEST_F(HandOverAgentTest, WhoWantsToBeToldNothingDoesNotAskWhereItIs) {
  int asked = 0;
  AgentOptions options;
  options.orders = std::make_shared<AgentOrders>();
  options.share.mode = ShareMode::kNone;
  options.ask_place = [&](const KeyframePayload&) {
    ++asked;
    return absl::StatusOr<std::optional<Rigid3d>>(Rigid3d::Identity());
  };
  const std::unique_ptr<Agent> agent = Make(options);
  int i = 0;
  for (; i < 20; ++i) Track(*agent, i);
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(agent->GetStatus().places_told, 0);
  EXPECT_FALSE(agent->GetStatus().global_from_local.has_value());
  options.orders->SetLimits({.share = ShareScope{.mode = ShareMode::kEverything}});
  for (; i < 25; ++i) Track(*agent, i);
  EXPECT_GT(asked, 0) << "its map store has other settings for it";
  EXPECT_GT(agent->GetStatus().places_told, 0);
  asked = 0;
  options.orders->SetLimits({.share = ShareScope{.mode = ShareMode::kNone}});
  agent->BeginLocalMap();
  for (; i < 45; ++i) Track(*agent, i);
  EXPECT_EQ(asked, 0);
}

// A map store whose link keeps the mapping thread waiting.
class HoldingUplink : public FakeUplink {
 public:
  void ResumeReading() override {
    if (std::this_thread::get_id() == tracking_) return;
    if (!holds.HasBeenNotified()) holds.Notify();
    go_on.WaitForNotificationWithTimeout(absl::Seconds(10));
  }
  absl::Notification holds;
  absl::Notification go_on;

 private:
  const std::thread::id tracking_ = std::this_thread::get_id();
};

TEST_F(HandOverAgentTest, TrackingDoesNotWaitForALocalMapToEnd) {
  HoldingUplink uplink;
  AgentOptions options;
  options.sensor.orb.features = 500;
  auto vocabulary =
      *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
  const auto agent = *Agent::Create(options, Calibration(), vocabulary, &uplink);
  int i = 0;
  for (; i < kFrames - 1 && !agent->GetStatus().first_upload_s.has_value(); ++i) {
    Track(*agent, i);
    absl::SleepFor(absl::Milliseconds(50));
  }
  ASSERT_TRUE(agent->GetStatus().first_upload_s.has_value());
  SharedUpdate much;
  much.moved_points.resize((size_t{64} << 20) / sizeof(SharedMapPointMove) + 1);
  uplink.Share(std::move(much));
  ASSERT_TRUE(uplink.holds.WaitForNotificationWithTimeout(absl::Seconds(10)));
  const absl::Time start = absl::Now();
  agent->BeginLocalMap();
  EXPECT_LT(absl::Now() - start, absl::Milliseconds(500)) << "mapping stands";
  EXPECT_EQ(Track(*agent, i).epoch, 2u);
  uplink.go_on.Notify();
  EXPECT_TRUE(agent->Finish(absl::Seconds(30)).ok());
  int closed = 0;
  for (const auto& [id, batches] : uplink.stored) closed += batches.back().closes_local_map;
  EXPECT_EQ(closed, 2) << "the first one is told to its end, too";
}

TEST_F(HandOverAgentTest, WithoutABoundTheMapGrows) {
  const std::unique_ptr<Agent> agent = Make(AgentOptions());
  for (int i = 0; i < 100; ++i) Track(*agent, i);
  EXPECT_EQ(agent->GetStatus().local_maps, 1);
  EXPECT_GT(agent->GetStatus().map_bytes, kFewBytes);
}

TEST_F(HandOverAgentTest, WithoutAStoreThereIsNoBound) {
  auto vocabulary =
      *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
  const auto agent = Agent::Create(Bounded(kFewBytes), Calibration(), vocabulary, nullptr);
  EXPECT_TRUE(absl::IsInvalidArgument(agent.status())) << agent.status();
}

}  // namespace
}  // namespace corbslam::client_agent

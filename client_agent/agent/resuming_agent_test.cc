// Tests a robot that is killed and goes on with its local map: it drives along a wall, alone or
// with a simulated map store.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <variant>

#include "client_agent/agent/agent.h"
#include "client_agent/agent/testing/driven_wall.h"
#include "client_agent/link/testing/fake_uplink.h"
#include "client_agent/spool/testing/fake_spool.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr int kDrive_px = 32;  // From frame to frame.
constexpr int kDriven = 24;
constexpr int64_t kBetween_ns = 100'000'000;

constexpr int kWallLength_px = 3 * kDriven * kDrive_px;

class ResumingAgentTest : public ::testing::Test {
 protected:
  std::unique_ptr<Agent> Make(Uplink* uplink = nullptr) {
    AgentOptions options = options_;
    options.deterministic = true;
    options.seed = ++seed_;
    options.sensor.orb.features = 1000;
    options.spool_within = absl::Seconds(1);
    auto vocabulary =
        *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
    return *Agent::Create(options, calibration_, vocabulary, uplink, *OpenFakeSpool(&disk_));
  }
  // Frame `number` shows the wall where frame `place` of a drive does.
  TrackingResult Track(Agent& agent, int place, int number) {
    const auto result = agent.Track(SeeWall(wall_, place * kDrive_px, number * kBetween_ns));
    EXPECT_TRUE(result.ok()) << result.status();
    return *result;
  }
  // A drive that ends with a SIGKILL. Returns its local map.
  LocalMapId DriveAndDie(Uplink* uplink = nullptr) {
    auto agent = Make(uplink);
    for (int i = 0; i < kDriven; ++i) Track(*agent, i, i);
    const LocalMapId local_map = agent->GetStatus().local_map;
    keyframes_ = agent->GetStatus().keyframes;
    const FakeDisk left = disk_;
    const auto stored = uplink_.stored;
    agent.reset();
    disk_ = left;
    uplink_.stored = stored;
    uplink_.open = false;
    return local_map;
  }

  AgentOptions options_;
  SensorCalibration calibration_ = WallCalibration();
  cv::Mat wall_ = LongWall(5, kWallLength_px);
  FakeDisk disk_;
  FakeUplink uplink_;
  uint64_t seed_ = 0;
  int keyframes_ = 0;
};

TEST_F(ResumingAgentTest, GoesOnInTheSameLocalMapWhereItRecognisesAPlace) {
  options_.resume = true;
  const LocalMapId before = DriveAndDie();
  const auto agent = Make();
  EXPECT_EQ(agent->GetStatus().local_map, before);
  EXPECT_EQ(agent->GetStatus().keyframes, keyframes_);
  const TrackingResult result = Track(*agent, kDriven / 2, kDriven + 10);
  ASSERT_EQ(result.state, TrackingState::kTracking);
  EXPECT_EQ(result.local_map, before);
  const double x = result.camera_from_local.Inverse().translation.x();
  EXPECT_NEAR(x, kDriven / 2 * kDrive_px * kWallPixel_m, 0.1);
  for (int i = 1; i < kDriven; ++i) {
    EXPECT_EQ(Track(*agent, kDriven / 2 + i, kDriven + 10 + i).state, TrackingState::kTracking);
  }
  const AgentStatus status = agent->GetStatus();
  EXPECT_TRUE(status.resumed);
  EXPECT_EQ(status.resumed_after_s, 0.0);
  EXPECT_EQ(status.why_not_resumed, "");
  EXPECT_EQ(status.local_map, before);
  EXPECT_GT(status.keyframes, keyframes_) << "the drive went further";
}

TEST_F(ResumingAgentTest, TheStoreHasOneLocalMapWithEachKeyframeOnce) {
  options_.resume = true;
  const LocalMapId before = DriveAndDie(&uplink_);
  const auto agent = Make(&uplink_);
  for (int i = 0; i < kDriven; ++i) Track(*agent, kDriven / 2 + i, kDriven + 10 + i);
  EXPECT_TRUE(agent->Finish(absl::Seconds(10)).ok());
  ASSERT_EQ(uplink_.stored.size(), 1u);
  std::set<KeyframeId> told;
  for (const MapUpdateBatch& batch : uplink_.stored[before]) {
    EXPECT_FALSE(batch.closes_local_map) << "the next process may go on with it";
    for (const FullKeyframe& full : batch.full_keyframes) {
      EXPECT_TRUE(told.insert(full.payload->id).second) << ToString(full.payload->id);
    }
  }
  EXPECT_EQ(agent->GetStatus().upload.lost_local_maps, 0);
}

TEST_F(ResumingAgentTest, WhereNothingIsRecognisedANewLocalMapBegins) {
  options_.resume = true;
  options_.resume_wait = absl::Seconds(1);
  const LocalMapId before = DriveAndDie();
  wall_ = LongWall(6, kWallLength_px);
  const auto agent = Make(&uplink_);
  int lost = 0;
  for (int i = 0; i < 20; ++i) {
    lost += Track(*agent, i / 4, kDriven + i).state == TrackingState::kTracking ? 0 : 1;
  }
  EXPECT_GE(lost, 10) << "for a second it is sought";
  EXPECT_LE(lost, 13);
  const AgentStatus status = agent->GetStatus();
  EXPECT_FALSE(status.resumed);
  EXPECT_NE(status.local_map, before);
  EXPECT_THAT(status.why_not_resumed, HasSubstr("recognised"));
  EXPECT_TRUE(agent->Finish(absl::Seconds(10)).ok());
  EXPECT_TRUE(uplink_.stored[before].back().closes_local_map);
}

TEST_F(ResumingAgentTest, AnotherCameraIsRefusedByName) {
  options_.resume = true;
  const LocalMapId before = DriveAndDie();
  std::get<StereoCalibration>(calibration_).camera.fx_px = 401;
  const auto agent = Make();
  EXPECT_NE(agent->GetStatus().local_map, before);
  EXPECT_THAT(agent->GetStatus().why_not_resumed, HasSubstr("another camera (f 400"));
}

TEST_F(ResumingAgentTest, TimeThatGoesBackIsRefused) {
  options_.resume = true;
  const LocalMapId before = DriveAndDie();
  const auto agent = Make();
  const TrackingResult result = Track(*agent, kDriven / 2, 0);
  EXPECT_NE(result.local_map, before);
  EXPECT_THAT(agent->GetStatus().why_not_resumed, HasSubstr("time goes back"));
}

TEST_F(ResumingAgentTest, WithoutResumeTheOldLocalMapIsClosedAndWhole) {
  const LocalMapId before = DriveAndDie();
  const auto agent = Make(&uplink_);
  Track(*agent, 0, kDriven);
  EXPECT_NE(agent->GetStatus().local_map, before);
  EXPECT_EQ(agent->GetStatus().why_not_resumed, "");
  EXPECT_TRUE(agent->Finish(absl::Seconds(10)).ok());
  ASSERT_FALSE(uplink_.stored[before].empty());
  EXPECT_TRUE(uplink_.stored[before].back().closes_local_map);
  int keyframes = 0;
  for (const MapUpdateBatch& batch : uplink_.stored[before]) {
    keyframes += static_cast<int>(batch.full_keyframes.size());
    for (const KeyframeRemoval& removal : batch.removed_keyframes) {
      for (const MapUpdateBatch& earlier : uplink_.stored[before]) {
        for (const FullKeyframe& full : earlier.full_keyframes) {
          keyframes -= full.payload->id == removal.id ? 1 : 0;
        }
      }
    }
  }
  EXPECT_EQ(keyframes, keyframes_);
}

// Without a map store a bounded robot's map goes to the disk.
TEST_F(ResumingAgentTest, ABoundedRobotWithoutAStoreHandsItsMapOverToTheDisk) {
  options_.max_map_bytes = 1 << 20;
  options_.max_outbox_bytes = 0;
  auto agent = Make();
  for (int i = 0; i < 3 * kDriven; ++i) {
    ASSERT_EQ(Track(*agent, i, i).state, TrackingState::kTracking) << i;
  }
  EXPECT_GE(agent->GetStatus().hand_overs, 1);
  EXPECT_TRUE(agent->Finish(absl::Seconds(10)).ok());
  EXPECT_EQ(agent->GetStatus().upload.memory_bytes, 0u);
  const int keyframes = agent->GetStatus().keyframes;
  agent.reset();
  // All of it goes up when there is a store.
  agent = Make(&uplink_);
  EXPECT_TRUE(agent->Finish(absl::Seconds(10)).ok());
  int stored = 0;
  for (const auto& [id, batches] : uplink_.stored) {
    for (const MapUpdateBatch& batch : batches) {
      stored += static_cast<int>(batch.full_keyframes.size());
    }
  }
  EXPECT_GE(stored, keyframes);
}

TEST(ResumeOptionsTest, ResumingNeedsASpool) {
  AgentOptions options;
  options.resume = true;
  auto vocabulary =
      *Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
  EXPECT_TRUE(absl::IsInvalidArgument(
      Agent::Create(options, WallCalibration(), vocabulary, nullptr).status()));
}

}  // namespace
}  // namespace corbslam::client_agent

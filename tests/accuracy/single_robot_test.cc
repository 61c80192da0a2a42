// Tests one robot against the truth of recorded sequences: bars as in
// docs/lab/2026-11-24-accuracy-lockstep.md.
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <map>
#include <string>

#include "client_agent/agent/agent.h"
#include "client_agent/source/recorded_sequence.h"
#include "slam/evaluation/trajectory_error.h"
#include "slam/evaluation/trajectory_io.h"

namespace corbslam::tests {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::OpenSource;
using client_agent::TrajectoryPose;

namespace {

constexpr int64_t kBeforeFrame15_ns = 1'500'000'000;  // KITTI: 10 Hz, times from zero.

class SingleRobotTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("CORBSLAM_DATA_DIR");
    if (folder == nullptr) {
      ASSERT_EQ(std::getenv("CI"), nullptr) << "CORBSLAM_DATA_DIR must be set";
      GTEST_SKIP() << "CORBSLAM_DATA_DIR is not set";
    }
    data_ = folder;
  }

  // Plays the source and returns the trajectory of every tracked frame. `take` may stamp a frame
  // anew, which the trajectory does not show, and returns false for one that is dropped.
  static Trajectory Run(
      const std::string& spec, int features,
      const std::function<bool(size_t, SensorImages&)>& take = [](size_t, SensorImages&) {
        return true;
      }) {
    auto source = OpenSource(spec);
    EXPECT_TRUE(source.ok()) << source.status();
    AgentOptions options;
    options.deterministic = true;
    options.sensor.orb.features = features;
    const auto vocabulary =
        Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) + "/slam/vocabulary/data/corbslam.voc");
    auto agent = Agent::Create(options, (*source)->calibration(), *vocabulary, nullptr);
    EXPECT_TRUE(agent.ok()) << agent.status();
    std::map<int64_t, int64_t> own_times;
    for (size_t i = 0; i < (*source)->size(); ++i) {
      auto images = (*source)->NextImages();
      EXPECT_TRUE(images.ok()) << images.status();
      const int64_t own_ns = (*images)->timestamp_ns;
      if (!take(i, **images)) continue;
      own_times[(*images)->timestamp_ns] = own_ns;
      EXPECT_TRUE((*agent)->Track(**images).ok());
    }
    EXPECT_TRUE((*agent)->Finish(absl::Minutes(1)).ok());
    EXPECT_EQ((*agent)->GetStatus().local_maps, 1);
    Trajectory trajectory;
    for (const TrajectoryPose& pose : (*agent)->LocalTrajectory()) {
      trajectory.push_back({own_times.at(pose.timestamp_ns), pose.local_from_camera});
    }
    return trajectory;
  }

  static double Rmse(const Trajectory& estimate, const Trajectory& truth) {
    return ComputeAbsoluteError(AssociateByTime(estimate, truth), Alignment::kSe3)->rmse_m;
  }

  std::string data_;
};

TEST_F(SingleRobotTest, KittiStreet) {
  const std::string folder = data_ + "/kitti_00_first201";
  const auto truth = ReadKittiTrajectory(folder + "/poses.txt", folder + "/times.txt");
  ASSERT_TRUE(truth.ok()) << truth.status();
  const Trajectory estimate = Run("kitti:" + folder, 2000);
  ASSERT_EQ(estimate.size(), 201u);
  EXPECT_LE(Rmse(estimate, *truth), 0.36);
  EXPECT_LE(Rmse(KeepFrom(estimate, kBeforeFrame15_ns), *truth), 0.215);
}

// As where the processor is short: now and then one to three frames in a row are missing.
TEST_F(SingleRobotTest, KittiStreetWithDroppedFrames) {
  const std::string folder = data_ + "/kitti_00_first201";
  const auto truth = ReadKittiTrajectory(folder + "/poses.txt", folder + "/times.txt");
  ASSERT_TRUE(truth.ok()) << truth.status();
  const Trajectory estimate = Run("kitti:" + folder, 2000, [](size_t i, SensorImages&) {
    const size_t in_turn = i % 17;
    return in_turn != 5 && (in_turn < 11 || in_turn >= 11 + i / 17 % 4);
  });
  ASSERT_EQ(estimate.size(), 171u);
  EXPECT_LE(Rmse(estimate, *truth), 0.36);
}

// A driver that stamps pictures when it hands them over, four at a time.
TEST_F(SingleRobotTest, KittiStreetStampedInBursts) {
  const std::string folder = data_ + "/kitti_00_first201";
  const auto truth = ReadKittiTrajectory(folder + "/poses.txt", folder + "/times.txt");
  ASSERT_TRUE(truth.ok()) << truth.status();
  const Trajectory estimate = Run("kitti:" + folder, 2000, [](size_t i, SensorImages& images) {
    images.timestamp_ns = static_cast<int64_t>(i / 4 * 400'000'000 + i % 4 * 5'000'000);
    return true;
  });
  ASSERT_EQ(estimate.size(), 201u);
  EXPECT_LE(Rmse(estimate, *truth), 0.36);
}

TEST_F(SingleRobotTest, TumDesk) {
  const std::string folder = data_ + "/tum_fr1_xyz_15hz";
  const auto truth = ReadTumTrajectory(folder + "/groundtruth.txt");
  ASSERT_TRUE(truth.ok()) << truth.status();
  const Trajectory estimate = Run("tum:" + folder, 1000);
  ASSERT_EQ(estimate.size(), 396u);
  EXPECT_LE(Rmse(estimate, *truth), 0.011);
}

// Half the frames are missing, so that the steps between frames are large.
TEST_F(SingleRobotTest, TumDeskInLargeSteps) {
  const std::string folder = data_ + "/tum_fr1_xyz_15hz";
  const auto truth = ReadTumTrajectory(folder + "/groundtruth.txt");
  ASSERT_TRUE(truth.ok()) << truth.status();
  const Trajectory estimate = Run("tum:" + folder + "?stride=2", 1000);
  EXPECT_GE(estimate.size(), 196u);
  EXPECT_LE(Rmse(estimate, *truth), 0.015);
}

}  // namespace
}  // namespace corbslam::tests

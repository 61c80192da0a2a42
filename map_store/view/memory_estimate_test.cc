#include "map_store/view/memory_estimate.h"

#include <gtest/gtest.h>

#include "map_store/testing/feature_mission.h"

namespace corbslam::map_store {
namespace {

constexpr uint64_t kOfAFeature = sizeof(Keypoint) + sizeof(Descriptor);

TEST(MemoryEstimateTest, FollowsWhatIsThere) {
  constexpr uint32_t kThere = 100;
  constexpr uint64_t kFeaturesEach = 1000;
  MissionState state = testing::MakeFeatureMission("m", kThere, kFeaturesEach);
  const uint64_t whole = EstimateMemory(state);
  EXPECT_GT(whole, kThere * kFeaturesEach * kOfAFeature);
  EXPECT_LT(whole, 3 * kThere * kFeaturesEach * kOfAFeature);
  LocalMapState& local_map = *state.FindLocalMap(LocalMapId{1});
  for (uint32_t i = 1; i < kThere; i += 2) local_map.map.RemoveKeyframe({LocalMapId{1}, i});
  ASSERT_EQ(local_map.map.keyframes().size(), kThere / 2);
  EXPECT_LT(EstimateMemory(state), 6 * whole / 10);
  EXPECT_GT(EstimateMemory(state), 4 * whole / 10);
}

TEST(MemoryEstimateTest, CountsWhatRobotsSayThatOnlyLocalise) {
  MissionState state = testing::MakeFeatureMission("m", 1, 1);
  const uint64_t before = EstimateMemory(state);
  LocalisedFrames part;
  part.run = part.number = 1;
  part.tracked_frames.resize(1000);
  AddPart(part, 1000, state.agents["guest"].track);
  EXPECT_GE(EstimateMemory(state), before + 1000 * sizeof(TrackedFrame));
  EXPECT_LT(EstimateMemory(state), before + 1100 * sizeof(TrackedFrame));
}

// All that it would look at has gone.
TEST(MemoryEstimateTest, LooksAtAnyKeyframeWhereItsSampleIsGone) {
  MissionState state = testing::MakeFeatureMission("m", 32, 1000);
  LocalMapState& local_map = *state.FindLocalMap(LocalMapId{1});
  for (uint32_t i = 0; i < 32; i += 2) local_map.map.RemoveKeyframe({LocalMapId{1}, i});
  EXPECT_GT(EstimateMemory(state), 16 * 1000 * kOfAFeature);
  EXPECT_LT(EstimateMemory(MissionState()), 10'000u);
}

}  // namespace
}  // namespace corbslam::map_store

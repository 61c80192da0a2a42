// Tests that an agent is said to be where its newest frame was, wherever its island stands.
#include "map_store/view/last_pose.h"

#include <gtest/gtest.h>

#include <memory>

#include "map_store/joining/local_map_joining.h"
#include "map_store/state/session_frames.h"

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kFirst = {0xa};
constexpr LocalMapId kSecond = {0xb};

// An agent with two local maps, of three keyframes at x = 0, 1, 2 each; a frame stands 0.5 m behind
// its keyframe.
class LastPoseTest : public ::testing::Test {
 protected:
  LastPoseTest() {
    for (const LocalMapId id : {kFirst, kSecond}) AddKeyframes(AddLocalMap(state_, id, "a"));
  }

  static void AddKeyframes(LocalMapState& local_map) {
    auto camera = std::make_shared<Camera>();
    *camera = {500, 500, 320, 240, 640, 480, 0.1, 4};
    for (uint32_t i = 0; i < 3; ++i) {
      Keyframe keyframe;
      keyframe.payload = MakeKeyframePayload({local_map.id, i}, i, 0, camera, {});
      keyframe.camera_from_map.translation = {-1.0 * i, 0, 0};
      if (i > 0) keyframe.parent = {local_map.id, i - 1};
      local_map.map.AddKeyframe(std::move(keyframe));
    }
  }

  LocalMapState& Of(LocalMapId id) { return *state_.FindLocalMap(id); }
  void Track(LocalMapId id, int64_t time_ns, KeyframeId reference) {
    const size_t before = Of(id).frames.size();
    Of(id).frames.push_back({time_ns, reference, {Eigen::Quaterniond::Identity(), {0.5, 0, 0}}});
    NoteNewestFrames(before, Of(id).lost_frames_ns.size(), Of(id));
  }
  void Lose(LocalMapId id, int64_t time_ns) {
    const size_t before = Of(id).lost_frames_ns.size();
    Of(id).lost_frames_ns.push_back(time_ns);
    NoteNewestFrames(Of(id).frames.size(), before, Of(id));
  }
  std::optional<LastPose> Find() const { return FindLastPose(state_, state_.agents.at("a")); }
  static double X(const LastPose& pose) {
    return pose.camera_from_island.Inverse().translation.x();
  }

  MissionState state_;
};

TEST_F(LastPoseTest, NoFrameNoPose) {
  EXPECT_FALSE(Find().has_value());
  Lose(kSecond, 5);
  EXPECT_FALSE(Find().has_value());
}

TEST_F(LastPoseTest, TheLatestTimeCountsWhateverCameLast) {
  Track(kFirst, 100, {kFirst, 0});
  Track(kFirst, 300, {kFirst, 2});
  Track(kFirst, 200, {kFirst, 1});
  const auto pose = Find();
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->timestamp_ns, 300);
  EXPECT_EQ(pose->local_map, kFirst);
  EXPECT_EQ(pose->island, kFirst);
  EXPECT_TRUE(pose->in_reference_island);
  EXPECT_FALSE(pose->lost_since);
  EXPECT_NEAR(X(*pose), 2.5, 1e-12);
}

TEST_F(LastPoseTest, ItMovesWithItsKeyframe) {
  Track(kFirst, 300, {kFirst, 2});
  Similarity3d placed =
      Similarity3d::FromRigid(Rigid3d{Eigen::Quaterniond::Identity(), {-12, 0, 0}});
  state_.global.keyframes[{kFirst, 2}] = {
      placed, Of(kFirst).map.FindKeyframe({kFirst, 2})->camera_from_map, 1};
  EXPECT_NEAR(X(*Find()), 12.5, 1e-12);
  Of(kFirst).map.SetPose({kFirst, 2}, {Eigen::Quaterniond::Identity(), {-7, 0, 0}});
  state_.global.keyframes.clear();
  ForgetChanges(state_, Of(kFirst));
  ++state_.version;
  TouchByOwner(state_, kFirst, true);
  EXPECT_NEAR(X(*Find()), 7.5, 1e-12);
}

TEST_F(LastPoseTest, TheNewestLocalMapCountsAndWhatWasLostSinceIsSaid) {
  Track(kFirst, 100, {kFirst, 0});
  Lose(kFirst, 90);
  EXPECT_FALSE(Find()->lost_since) << "it was found again";
  Lose(kFirst, 110);
  EXPECT_TRUE(Find()->lost_since);
  Track(kFirst, 120, {kFirst, 1});
  EXPECT_FALSE(Find()->lost_since);
  Lose(kSecond, 130);
  EXPECT_EQ(Find()->local_map, kFirst);
  EXPECT_TRUE(Find()->lost_since) << "in a later local map";
  Track(kSecond, 140, {kSecond, 1});
  const auto pose = Find();
  EXPECT_EQ(pose->local_map, kSecond);
  EXPECT_EQ(pose->island, kSecond);
  EXPECT_FALSE(pose->in_reference_island);
  EXPECT_FALSE(pose->lost_since);
  EXPECT_NEAR(X(*pose), 1.5, 1e-12);
}

// Fuses the local map with the first one, of which it becomes a part.
void Join(LocalMapId part, MissionState& state) {
  Island& island = state.global.islands.at(kFirst);
  state.global.islands.erase(part);
  island.local_maps.push_back(part);
  SetIslandOf(*state.FindLocalMap(part), kFirst, state);
  ApplyJoining({part, kFirst, Rigid3d::Identity()}, state);
}

// A robot's clock may begin anew with each start.
TEST_F(LastPoseTest, TheNewestSessionOfAWholeCountsWhateverItsClockSays) {
  Track(kFirst, 900, {kFirst, 2});
  Lose(kFirst, 950);
  Track(kSecond, 100, {kSecond, 0});
  Track(kSecond, 120, {kSecond, 1});
  Track(kSecond, 110, {kSecond, 0});
  Join(kSecond, state_);
  for (const bool read_again : {false, true}) {
    const auto pose = Find();
    ASSERT_TRUE(pose.has_value());
    EXPECT_EQ(pose->timestamp_ns, 120) << read_again;
    EXPECT_EQ(pose->local_map, kFirst);
    EXPECT_FALSE(pose->lost_since) << "the session before was lost";
    EXPECT_NEAR(X(*pose), 1.5, 1e-12);
    NoteNewestOfSessions(Of(kFirst));
  }
}

TEST_F(LastPoseTest, ASessionThatWasLostAllAlongLeavesTheOneBefore) {
  Track(kFirst, 900, {kFirst, 2});
  Lose(kSecond, 5);
  Join(kSecond, state_);
  EXPECT_EQ(Find()->timestamp_ns, 900);
  EXPECT_TRUE(Find()->lost_since) << "in a later session, whatever its clock says";
}

// The second local map stays as it is; the third one becomes a part of the first.
TEST_F(LastPoseTest, APartMayBeNewerThanALocalMapThatStandsBehindItsWhole) {
  constexpr LocalMapId kThird = {0x3};
  constexpr LocalMapId kFourth = {0x4};
  for (const LocalMapId id : {kThird, kFourth}) AddKeyframes(AddLocalMap(state_, id, "a"));
  Track(kFirst, 900, {kFirst, 2});
  Track(kSecond, 500, {kSecond, 1});
  Track(kThird, 70, {kThird, 0});
  Track(kFourth, 30, {kFourth, 1});
  // The older one becomes a part last.
  Join(kFourth, state_);
  EXPECT_EQ(Find()->timestamp_ns, 30);
  Join(kThird, state_);
  EXPECT_EQ(Find()->timestamp_ns, 30);
  EXPECT_NEAR(X(*Find()), 1.5, 1e-12);
}

TEST_F(LastPoseTest, AFrameThatRefersToNothingIsPassedOver) {
  Track(kFirst, 100, {kFirst, 1});
  Track(kFirst, 200, {kFirst, 77});
  Track(kFirst, 300, {kSecond, 1});
  EXPECT_EQ(Find()->timestamp_ns, 100) << "the last one refers to another island";
}

TEST_F(LastPoseTest, ARemovedKeyframesFrameFollowsItsRelative) {
  Track(kFirst, 100, {kFirst, 2});
  Of(kFirst).map.RemoveKeyframe({kFirst, 2});
  Of(kFirst).removed_keyframes[{kFirst, 2}] = {{kFirst, 1},
                                               {Eigen::Quaterniond::Identity(), {1, 0, 0}}};
  EXPECT_NEAR(X(*Find()), 2.5, 1e-12);
}

}  // namespace
}  // namespace corbslam::map_store

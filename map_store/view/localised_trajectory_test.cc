// Tests that what a robot localised moves with the map, and that its gaps are said.
#include "map_store/view/localised_trajectory.h"

#include <gtest/gtest.h>

#include <memory>

#include "map_store/view/last_pose.h"
#include "map_store/view/trajectory.h"

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kReferenceMap = {0xa};
constexpr LocalMapId kApartMap = {0xb};
constexpr double kSame = 1e-9;

// Two local maps of another agent, each an island, of three keyframes at x = 0, 1, 2. The guest's
// frames stand 0.5 m behind their keyframes.
class LocalisedTrajectoryTest : public ::testing::Test {
 protected:
  LocalisedTrajectoryTest() {
    for (const LocalMapId id : {kReferenceMap, kApartMap}) {
      FillLocalMap(AddLocalMap(state_, id, "mapper"));
    }
  }

  static void FillLocalMap(LocalMapState& local_map) {
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
  static Rigid3d Shift(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 0}}; }

  LocalMapState& Of(LocalMapId id) { return *state_.FindLocalMap(id); }
  void Say(const std::vector<std::pair<int64_t, KeyframeId>>& frames,
           const std::vector<int64_t>& lost_ns = {}, uint64_t run = 1,
           std::optional<RecordedCamera> camera = std::nullopt) {
    LocalisedFrames part;
    part.run = run;
    const LocalisedRun* before = FindRun(Guest().track, run);
    part.number = before == nullptr ? 1 : before->last_number + 1;
    part.recorded_camera = std::move(camera);
    for (const auto& [time_ns, id] : frames)
      part.tracked_frames.push_back({time_ns, id, Shift(0.5)});
    part.lost_frames_ns = lost_ns;
    AddPart(part, 1000, Guest().track);
  }
  AgentState& Guest() { return state_.agents["guest"]; }
  std::vector<StoredPose> Poses(bool all_islands = false) {
    const auto trajectory = ComputeTrajectory(state_, "guest", TrajectoryFrame::kGlobal,
                                              all_islands, PosesOf::kRectifiedCamera);
    EXPECT_TRUE(trajectory.ok()) << trajectory.status();
    return trajectory->poses;
  }
  // Places a keyframe; the state is another one then.
  void Place(KeyframeId id, const Similarity3d& camera_from_island) {
    state_.global.keyframes[id] = {camera_from_island, state_.FindKeyframe(id)->camera_from_map, 1};
    TouchByFusion(state_, state_.global.island_of.at(id.local_map));
  }

  MissionState state_;
};

TEST_F(LocalisedTrajectoryTest, ItMovesWithTheMap) {
  Say({{100, {kReferenceMap, 1}}, {200, {kReferenceMap, 2}}});
  std::vector<StoredPose> poses = Poses();
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_NEAR(poses[0].frame_from_camera.translation.x(), 1.5, kSame);
  EXPECT_NEAR(poses[1].frame_from_camera.translation.x(), 2.5, kSame);
  EXPECT_EQ(poses[0].run, 1u);
  EXPECT_FALSE(poses[0].local_map.IsValid());
  EXPECT_EQ(poses[0].island, kReferenceMap);
  Place({kReferenceMap, 2}, Similarity3d::FromRigid(Shift(-12)));
  poses = Poses();
  EXPECT_NEAR(poses[1].frame_from_camera.translation.x(), 12.5, kSame);
  EXPECT_NEAR(FindLastPose(state_, Guest())->camera_from_island.Inverse().translation.x(), 12.5,
              kSame);
}

TEST_F(LocalisedTrajectoryTest, ItIsInTheGlobalFramesUnits) {
  Say({{100, {kReferenceMap, 2}}});
  Similarity3d placed = Similarity3d::FromRigid(Shift(-24));
  placed.scale = 2;  // The owner's units are half as long as the island's.
  Place({kReferenceMap, 2}, placed);
  EXPECT_NEAR(Poses()[0].frame_from_camera.translation.x(), 12.5, kSame);
}

TEST_F(LocalisedTrajectoryTest, GapsAreSaid) {
  Say({{100, {kReferenceMap, 0}}, {200, {kReferenceMap, 1}}}, {150});
  Say({{300, {kReferenceMap, 1}}, {400, {kReferenceMap, 77}}, {500, {kReferenceMap, 1}}});
  Say({{50, {kReferenceMap, 0}}}, {}, /*run=*/2);
  const std::vector<StoredPose> poses = Poses();
  ASSERT_EQ(poses.size(), 5u);
  EXPECT_FALSE(poses[0].after_gap);
  EXPECT_TRUE(poses[1].after_gap) << "it was lost in between";
  EXPECT_FALSE(poses[2].after_gap);
  EXPECT_EQ(poses[3].timestamp_ns, 500) << "nobody knows the keyframe of the one before";
  EXPECT_TRUE(poses[3].after_gap);
  EXPECT_TRUE(poses[4].after_gap) << "another run has another clock";
}

TEST_F(LocalisedTrajectoryTest, WhatStandsForAKeyframeCarriesItsFrames) {
  Say({{100, {kReferenceMap, 2}}});
  // The owner removed it.
  Of(kReferenceMap).map.RemoveKeyframe({kReferenceMap, 2});
  Of(kReferenceMap).removed_keyframes[{kReferenceMap, 2}] = {{kReferenceMap, 1}, Shift(1)};
  EXPECT_NEAR(Poses()[0].frame_from_camera.translation.x(), 2.5, kSame);
  // The store let go of it: another one stands in, which has moved since.
  state_.global.stand_ins[{kReferenceMap, 2}] = {{kReferenceMap, 0}, Shift(2)};
  Place({kReferenceMap, 0}, Similarity3d::FromRigid(Shift(-10)));
  EXPECT_NEAR(Poses()[0].frame_from_camera.translation.x(), 12.5, kSame);
}

TEST_F(LocalisedTrajectoryTest, OtherIslandsAreLeftOutUnlessWanted) {
  Say({{100, {kReferenceMap, 0}}, {200, {kApartMap, 1}}, {300, {kReferenceMap, 1}}});
  std::vector<StoredPose> poses = Poses();
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_TRUE(poses[1].after_gap);
  poses = Poses(/*all_islands=*/true);
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_EQ(poses[1].island, kApartMap);
  EXPECT_TRUE(poses[1].after_gap);
  EXPECT_TRUE(poses[2].after_gap);
}

TEST_F(LocalisedTrajectoryTest, PosesAreOfTheFrameThatIsWanted) {
  RecordedCamera recorded;
  recorded.body_from_recorded = Shift(3);
  Say({{100, {kReferenceMap, 0}}}, {}, 1, recorded);
  const auto body =
      ComputeTrajectory(state_, "guest", TrajectoryFrame::kGlobal, false, PosesOf::kBody);
  ASSERT_TRUE(body.ok()) << body.status();
  EXPECT_NEAR(body->poses[0].frame_from_camera.translation.x(), 0.5 - 3, kSame);
  Say({{100, {kReferenceMap, 0}}}, {}, 2);
  const absl::Status unknown =
      ComputeTrajectory(state_, "guest", TrajectoryFrame::kGlobal, false, PosesOf::kBody).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(unknown)) << unknown;
}

TEST_F(LocalisedTrajectoryTest, NothingOfItIsInALocalFrame) {
  Say({{100, {kReferenceMap, 0}}});
  const auto local =
      ComputeTrajectory(state_, "guest", TrajectoryFrame::kLocal, false, PosesOf::kRectifiedCamera);
  ASSERT_TRUE(local.ok()) << local.status();
  EXPECT_TRUE(local->poses.empty());
}

TEST_F(LocalisedTrajectoryTest, OfWhatHasNoPoseTheNumberIsSaid) {
  Say({{100, {kReferenceMap, 0}}, {200, {kReferenceMap, 77}}, {300, {kApartMap, 1}}}, {150, 250});
  Say({}, {400}, /*run=*/2);
  Guest().track.dropped = 5;
  const auto count = [this](TrajectoryFrame frame, bool all_islands) {
    const auto answer =
        ComputeTrajectory(state_, "guest", frame, all_islands, PosesOf::kRectifiedCamera);
    EXPECT_EQ(answer->lost, 3u);
    EXPECT_EQ(answer->dropped, 5u);
    EXPECT_EQ(answer->poses.size() + answer->left_out, 3u);
    return answer->left_out;
  };
  EXPECT_EQ(count(TrajectoryFrame::kGlobal, /*all_islands=*/false), 2u);
  EXPECT_EQ(count(TrajectoryFrame::kGlobal, /*all_islands=*/true), 1u);
  EXPECT_EQ(count(TrajectoryFrame::kLocal, /*all_islands=*/false), 3u);
}

TEST_F(LocalisedTrajectoryTest, OfARobotThatMapsLikewise) {
  for (const LocalMapId id : {kReferenceMap, kApartMap}) {
    Of(id).frames = {{100, {id, 1}, {}}, {200, {id, 77}, {}}, {300, {id, 2}, {}}};
    Of(id).lost_frames_ns = {150, 160};
  }
  const auto count = [this](TrajectoryFrame frame, bool all_islands) {
    const auto answer =
        ComputeTrajectory(state_, "mapper", frame, all_islands, PosesOf::kRectifiedCamera);
    EXPECT_EQ(answer->lost, 4u);
    EXPECT_EQ(answer->poses.size() + answer->left_out, 6u);
    return answer->left_out;
  };
  EXPECT_EQ(count(TrajectoryFrame::kGlobal, /*all_islands=*/false), 4u);
  EXPECT_EQ(count(TrajectoryFrame::kGlobal, /*all_islands=*/true), 2u);
  EXPECT_EQ(count(TrajectoryFrame::kLocal, /*all_islands=*/false), 2u);
}

TEST_F(LocalisedTrajectoryTest, ThePoseThatIsLastSaysWhatWasLostSince) {
  Say({{100, {kReferenceMap, 0}}});
  EXPECT_FALSE(FindLastPose(state_, Guest())->lost_since);
  Say({}, {200}, 2);
  const auto last = FindLastPose(state_, Guest());
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->timestamp_ns, 100);
  EXPECT_TRUE(last->lost_since) << "in a later run";
}

}  // namespace
}  // namespace corbslam::map_store

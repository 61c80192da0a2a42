#include "map_store/joining/local_map_joining.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "map_store/archive/feature_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/fusion/rederivation.h"
#include "map_store/ingest/gone_local_maps.h"
#include "map_store/joining/forgetting.h"
#include "map_store/joining/joining_choice.h"
#include "map_store/records/record_application.h"
#include "map_store/records/retraction.h"
#include "map_store/records/state_validation.h"
#include "map_store/retiring/retirement.h"
#include "map_store/retiring/retiring_view.h"
#include "map_store/testing/many_starts.h"
#include "map_store/view/map_replay.h"
#include "map_store/view/placement.h"
#include "map_store/view/trajectory.h"

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kKeyframesOfStart;
using testing::MakeManyStarts;

std::map<KeyframeId, Similarity3d> AllPoses(const MissionState& state) {
  std::map<KeyframeId, Similarity3d> poses;
  for (const auto& [id, local_map] : state.local_maps) {
    const IslandPoses own = ComputePoses(local_map, state.global);
    poses.insert(own.begin(), own.end());
  }
  return poses;
}

size_t JoinAll(MissionState& state, size_t kept) {
  size_t joined = 0;
  while (const auto joining = ChooseJoining(state, kept)) {
    const JoinRecord record{*joining};
    EXPECT_TRUE(CheckReplay(record, state).ok());
    Apply(record, state);
    ++joined;
  }
  return joined;
}

void ExpectSamePoses(const std::map<KeyframeId, Similarity3d>& a,
                     const std::map<KeyframeId, Similarity3d>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [id, pose] : a) {
    const Similarity3d difference = pose * b.at(id).Inverse();
    EXPECT_LT(difference.translation.norm(), 1e-9) << ToString(id);
    EXPECT_LT(difference.rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-7);
    EXPECT_NEAR(difference.scale, 1, 1e-12);
  }
}

TEST(LocalMapJoiningTest, AThousandStartsEndInFewLocalMapsThatStandWhereTheyStood) {
  MissionState state = MakeManyStarts(1000);
  const auto before = AllPoses(state);
  const Eigen::Vector3d point =
      ComputePosition(*state.FindPoint({{700}, 2}), *state.FindLocalMap({700}), state.global,
                      ComputePoses(*state.FindLocalMap({700}), state.global));
  EXPECT_EQ(JoinAll(state, 8), 991u);
  EXPECT_EQ(state.local_maps.size(), 9u);
  EXPECT_EQ(state.agents.at("r").local_maps.size(), 9u);
  ExpectSamePoses(AllPoses(state), before);
  const LocalMapState& whole = *state.FindLocalMap({700});
  EXPECT_EQ(whole.id, LocalMapId{1});
  EXPECT_EQ(whole.arrived.size(), 992 * kKeyframesOfStart);
  EXPECT_LT((ComputePosition(*state.FindPoint({{700}, 2}), whole, state.global,
                             ComputePoses(whole, state.global)) -
             point)
                .norm(),
            1e-9);
  EXPECT_TRUE(ValidateState(state).ok()) << ValidateState(state);
}

// Local poses of the parts are in the frame of the whole: alone, it keeps its shape.
TEST(LocalMapJoiningTest, TheWholeIsOneMapWithoutFusion) {
  MissionState state = MakeManyStarts(12);
  const auto before = AllPoses(state);
  JoinAll(state, 2);
  ForgetGlobalLayer(state);
  const Similarity3d island_from_whole = testing::IslandFromStart(1);
  for (const auto& [id, pose] : ComputePoses(*state.FindLocalMap({1}), state.global)) {
    const Similarity3d difference = pose * island_from_whole.Inverse() * before.at(id).Inverse();
    EXPECT_LT(difference.translation.norm(), 1e-9) << ToString(id);
  }
  EXPECT_EQ(state.global.island_of.at({5}), LocalMapId{1});
  EXPECT_TRUE(ValidateState(state).ok()) << ValidateState(state);
}

TEST(LocalMapJoiningTest, ASnapshotHasTheSame) {
  MissionState state = MakeManyStarts(12);
  JoinAll(state, 2);
  const FeatureLoader load = [](KeyframeId) {
    Features features;
    features.keypoints.resize(4);
    features.descriptors.resize(4);
    return features;
  };
  const auto again = DecodeState(EncodeState(state), load);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(EncodeState(*again), EncodeState(state));
  EXPECT_EQ(again->joined_into, state.joined_into);
  EXPECT_EQ(again->FindLocalMap({7})->id, LocalMapId{1});
  EXPECT_EQ(LastBatchOf(*again, {7}), 17u);
  EXPECT_EQ(again->arrivals.NumberOfAgent({7}), 7u) << "parts keep their numbers";
}

TEST(LocalMapJoiningTest, ARobotThatComesBackToAPartIsToldSo) {
  MissionState state = MakeManyStarts(4);
  JoinAll(state, 1);
  EXPECT_EQ(LastBatchOf(state, {2}), 12u) << "what it sent is acknowledged";
  const absl::Status status = CheckTakesBatches(state, {2});
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("begin a new local map"));
  const absl::Status of_whole = CheckTakesBatches(state, {1});
  EXPECT_TRUE(absl::IsFailedPrecondition(of_whole)) << "its frames would be the last part's";
  EXPECT_THAT(std::string(of_whole.message()), HasSubstr("begin a new local map"));
  EXPECT_TRUE(CheckTakesBatches(state, {4}).ok());
  EXPECT_TRUE(CheckTakesBatches(state, {99}).ok());
}

// Clocks may begin anew with each start of a robot.
TEST(LocalMapJoiningTest, ATrajectoryGoesThroughOneSessionAfterTheOther) {
  MissionState state = MakeManyStarts(4);
  JoinAll(state, 1);
  const auto trajectory =
      ComputeTrajectory(state, "r", TrajectoryFrame::kGlobal, false, PosesOf::kRectifiedCamera);
  ASSERT_TRUE(trajectory.ok()) << trajectory.status();
  ASSERT_EQ(trajectory->poses.size(), 4 * kKeyframesOfStart);
  for (size_t i = 0; i < trajectory->poses.size(); ++i) {
    EXPECT_EQ(trajectory->poses[i].timestamp_ns, static_cast<int64_t>(1000 + i % 3));
    EXPECT_EQ(trajectory->poses[i].after_gap, i > 0 && i % 3 == 0) << i;
    // Whoever sorts poses by time keeps sessions apart by this.
    EXPECT_EQ(trajectory->poses[i].local_map, (LocalMapId{1 + i / kKeyframesOfStart})) << i;
  }
}

TEST(LocalMapJoiningTest, AFrameAgainstOthersGoesBackThroughItsOwnSession) {
  MissionState state = MakeManyStarts(4);
  state.FindLocalMap({1})->frames.push_back({1005, {{4}, 0}, {}});
  JoinAll(state, 1);
  const auto compute = [&state] {
    return ComputeTrajectory(state, "r", TrajectoryFrame::kLocal, false, PosesOf::kRectifiedCamera);
  };
  const auto before = compute();
  ASSERT_TRUE(before.ok()) << before.status();
  ASSERT_EQ(before->poses.at(kKeyframesOfStart).timestamp_ns, 1005);
  // Fusion puts another session elsewhere.
  for (uint32_t i = 0; i < kKeyframesOfStart; ++i) {
    const auto placed = state.global.keyframes.find({{2}, i});
    if (placed == state.global.keyframes.end()) continue;
    placed->second.camera_from_island.translation.x() += 0.5;
  }
  state.FindLocalMap({1})->places_version = ++state.version;
  const auto after = compute();
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_LT((after->poses.at(kKeyframesOfStart).frame_from_camera.translation -
             before->poses.at(kKeyframesOfStart).frame_from_camera.translation)
                .norm(),
            1e-9);
}

// Nothing of a visit need stay but where the robot went.
TEST(LocalMapJoiningTest, AllKeyframesOfAPartMayRetire) {
  MissionState state = MakeManyStarts(4);
  JoinAll(state, 1);
  const auto compute = [&state] {
    return ComputeTrajectory(state, "r", TrajectoryFrame::kLocal, false, PosesOf::kRectifiedCamera);
  };
  const auto before = compute();
  ASSERT_TRUE(before.ok()) << before.status();
  const KeyframeId stays{{1}, 0};
  const Map& map = state.FindLocalMap({1})->map;
  Retirement retirement;
  for (uint32_t i = 0; i < kKeyframesOfStart; ++i) {
    const KeyframeId id{{2}, i};
    const Rigid3d stays_from_gone =
        map.FindKeyframe(stays)->camera_from_map * map.FindKeyframe(id)->camera_from_map.Inverse();
    retirement.keyframes.push_back({id, stays, stays_from_gone, {stays, stays_from_gone}});
  }
  ASSERT_TRUE(CheckRetirement(retirement, state).ok()) << CheckRetirement(retirement, state);
  ApplyRetirement(retirement, state);
  for (const auto& [id, keyframe] : map.keyframes()) EXPECT_NE(id.local_map, LocalMapId{2});
  for (const auto& [id, point] : map.points()) EXPECT_NE(id.local_map, LocalMapId{2});
  EXPECT_TRUE(state.FindLocalMap({1})->removed_points.empty()) << "names of points would pile up";
  EXPECT_TRUE(ValidateState(state).ok()) << ValidateState(state);
  const auto after = compute();
  ASSERT_TRUE(after.ok()) << after.status();
  ASSERT_EQ(after->poses.size(), before->poses.size());
  for (size_t i = 0; i < before->poses.size(); ++i) {
    EXPECT_LT((after->poses[i].frame_from_camera.translation -
               before->poses[i].frame_from_camera.translation)
                  .norm(),
              1e-9)
        << i;
  }
  // Another agent's keyframe can stand in, but local poses are not relative to it.
  retirement.keyframes = {{{{3}, 0}, {{77}, 0}, {}, {stays, {}}}};
  EXPECT_TRUE(absl::IsDataLoss(CheckRetirement(retirement, state)));
}

// What others missed before a session says nothing of what it saw.
TEST(LocalMapJoiningTest, RetiringSeesSessionsInTheOrderInWhichTheyCame) {
  MissionState state = MakeManyStarts(4);
  ApplyJoining({{3}, {1}, Rigid3d()}, state);
  UnbrokenRead read;
  const auto view = TakeRetiringView(state, state.global.islands.at({1}), {}, {}, read);
  ASSERT_TRUE(view.ok()) << view.status();
  ASSERT_EQ(view->closed.size(), 4u);
  EXPECT_LT(view->closed.at({1}).order, view->closed.at({2}).order);
  EXPECT_LT(view->closed.at({2}).order, view->closed.at({3}).order);
  EXPECT_LT(view->closed.at({3}).order, view->closed.at({4}).order);
}

TEST(LocalMapJoiningTest, AReplayCountsBatchesOfPartsAndOfTheDeleted) {
  MissionState state = MakeManyStarts(4);
  const uint64_t batches = ProgressOf(state).batches;
  JoinAll(state, 1);
  EXPECT_EQ(ProgressOf(state).batches, batches);
  ForgetLocalMaps({LocalMapId{1}}, state);
  EXPECT_EQ(ProgressOf(state).batches, batches);
}

TEST(LocalMapJoiningTest, PartsThatCanNotBeAreDamage) {
  MissionState state = MakeManyStarts(4);
  JoinAll(state, 1);
  ASSERT_TRUE(ValidateState(state).ok()) << ValidateState(state);
  MissionState beyond = state;
  beyond.FindLocalMap({1})->joined.back().first_frame = 99;
  EXPECT_TRUE(absl::IsDataLoss(ValidateState(beyond)));
  MissionState backwards = state;
  backwards.FindLocalMap({1})->joined.back().first_frame = 0;
  EXPECT_TRUE(absl::IsDataLoss(ValidateState(backwards)));
  MissionState deleted = state;
  deleted.forgotten[{2}] = 1;
  EXPECT_TRUE(absl::IsDataLoss(ValidateState(deleted)));
  MissionState twice = state;
  twice.FindLocalMap({4})->AddPart({{2}, 1, 0, 0});
  EXPECT_TRUE(absl::IsDataLoss(ValidateState(twice)));
  MissionState others = state;
  const std::map<uint64_t, LocalMapId> names = state.arrivals.names();
  others.arrivals = ArrivalBook(0, names, {{"r", {{1}, {2}, {3}}}, {"s", {{4}}}});
  EXPECT_TRUE(absl::IsDataLoss(ValidateState(others))) << "another agent's number";
  others.arrivals = ArrivalBook(0, names, {{"r", {{1}, {2}, {3}, {4}, {2}}}});
  EXPECT_TRUE(absl::IsDataLoss(ValidateState(others))) << "two numbers";
}

void AddJoiningOverlap(KeyframeId query, KeyframeId candidate, MissionState& state) {
  OverlapEntry entry;
  entry.id = state.next_overlap++;
  entry.overlap.query = query;
  entry.overlap.candidate = candidate;
  entry.overlap.verdict = OverlapVerdict::kAccepted;
  entry.state = OverlapState::kInGraph;
  state.global.overlaps.Add(entry);
}

TEST(LocalMapJoiningTest, WhatIsKeptApartIsKeptFromAllParts) {
  MissionState state = MakeManyStarts(4);
  JoinAll(state, 1);
  AddJoiningOverlap({{4}, 0}, {{1}, 0}, state);
  AddJoiningOverlap({{4}, 1}, {{2}, 0}, state);
  const RetractRecord record{2, true};
  ASSERT_TRUE(CheckRetraction(state, record).ok());
  EXPECT_THAT(Retract(record, {}, state), ElementsAre(1u, 2u));
  EXPECT_TRUE(state.global.overlaps.waiting().empty()) << "nothing would hold them together again";
  Overlap later;
  later.query = {{4}, 2};
  later.candidate = {{3}, 0};
  EXPECT_TRUE(IsTakenBack(later, state));
  EXPECT_TRUE(ValidateState(state).ok()) << ValidateState(state);
}

TEST(LocalMapJoiningTest, TheOverlapThatJoinedThemIsNotTakenBackAnyMore) {
  MissionState state = MakeManyStarts(4);
  for (const uint64_t other : {2, 4}) AddJoiningOverlap({{other}, 0}, {{1}, 0}, state);
  EXPECT_TRUE(CheckRetraction(state, {1, false}).ok());
  JoinAll(state, 1);
  const absl::Status status = CheckRetraction(state, {1, false});
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("retired into one"));
  ASSERT_TRUE(CheckRetraction(state, {2, false}).ok()) << "the newest one stayed apart";
  Retract({2, false}, {}, state);
  EXPECT_EQ(state.global.islands.size(), 2u);
  EXPECT_EQ(state.global.island_of.at({3}), LocalMapId{1});
  EXPECT_TRUE(ValidateState(state).ok()) << ValidateState(state);
}

TEST(LocalMapJoiningTest, StaysAsItIs) {
  const auto expect_none = [](const MissionState& state) {
    EXPECT_FALSE(ChooseJoining(state, 0).has_value());
  };
  const MissionState two = MakeManyStarts(2);
  EXPECT_TRUE(ChooseJoining(two, 0).has_value());
  EXPECT_FALSE(ChooseJoining(two, 1).has_value()) << "the newest ones stay";
  MissionState open = two;
  open.FindLocalMap({2})->closed = false;
  expect_none(open);
  MissionState other_unit = two;
  other_unit.global.island_from_local.at({2}).scale = 1.1;
  expect_none(other_unit);
  MissionState other_camera = two;
  other_camera.FindLocalMap({2})->cameras = {
      std::make_shared<const Camera>(Camera{501, 500, 320, 240, 640, 480, 0.1, 4})};
  expect_none(other_camera);
  MissionState apart = two;
  apart.global.kept_apart.insert({LocalMapId{1}, LocalMapId{9}});
  expect_none(apart);
  MissionState not_joined = MakeManyStarts(1);
  testing::AddStart(2, false, not_joined);
  expect_none(not_joined);
}

// Takes away where the session's keyframes stand, which then follow others of no relation.
void Unplace(uint64_t session, MissionState& state) {
  for (uint32_t i = 0; i < kKeyframesOfStart; ++i) state.global.keyframes.erase({{session}, i});
}

TEST(LocalMapJoiningTest, WhatCanNotBecomeOneIsLookedAtOnceUntilItChanges) {
  constexpr uint64_t kSessions = 60;
  MissionState state = MakeManyStarts(kSessions);
  for (uint64_t session = 1; session <= kSessions; ++session) Unplace(session, state);
  JoiningMemory memory;
  EXPECT_FALSE(ChooseJoining(state, 1, memory).has_value());
  EXPECT_LE(memory.walked, kSessions) << "not each pair of them";
  const uint64_t walked = memory.walked;
  ++state.version;  // A batch came.
  EXPECT_FALSE(ChooseJoining(state, 1, memory).has_value());
  EXPECT_EQ(memory.walked, walked);
  state.global.keyframes[{{7}, 0}].camera_from_island = testing::IslandFromStart(7).Inverse();
  state.global.keyframes[{{9}, 0}].camera_from_island = testing::IslandFromStart(9).Inverse();
  ++state.global.revision;  // Fusion placed two of them.
  const auto joining = ChooseJoining(state, 1, memory);
  ASSERT_TRUE(joining.has_value());
  EXPECT_EQ(joining->part, LocalMapId{9});
  EXPECT_EQ(joining->whole, LocalMapId{7});
  ApplyJoining(*joining, state);
  EXPECT_FALSE(ChooseJoining(state, 1, memory).has_value());
  EXPECT_EQ(memory.trees.count({9}), 0u) << "it is no local map any more";
}

TEST(LocalMapJoiningTest, SessionsOfTwoCamerasBecomeTwo) {
  MissionState state = MakeManyStarts(9);
  for (const uint64_t session : {2, 4, 5}) {
    state.FindLocalMap({session})->cameras = {
        std::make_shared<const Camera>(Camera{501, 500, 320, 240, 640, 480, 0.1, 4})};
  }
  // Alike at first sight only.
  state.FindLocalMap({8})->cameras = {
      std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.2, 4})};
  EXPECT_EQ(JoinAll(state, 1), 5u);
  EXPECT_EQ(state.FindLocalMap({7})->id, LocalMapId{1});
  EXPECT_EQ(state.FindLocalMap({5})->id, LocalMapId{2});
  EXPECT_EQ(state.FindLocalMap({8})->id, LocalMapId{8});
  EXPECT_TRUE(state.FindLocalMap({1})->IsNamed({7}));
  EXPECT_FALSE(state.FindLocalMap({1})->IsNamed({5}));
}

}  // namespace
}  // namespace corbslam::map_store

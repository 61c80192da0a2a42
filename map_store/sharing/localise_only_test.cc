// Tests sessions of robots that change nothing: they are told of the map around them, in its frame.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "map_store/testing/sharing_mission.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;
using testing::TestAgent;

constexpr size_t kAll_bytes = 100 << 20;
// The robot drove on a ring of 15 m, a keyframe every metre.
constexpr ShareScope kNear = {ShareMode::kNearby, 3};

class LocaliseOnlyTest : public testing::SharingMission {
 protected:
  static SessionRequest Request(const std::string& mission, const ShareScope& scope) {
    SessionRequest request;
    request.mission = mission;
    request.agent = "guest";
    request.share = scope;
    request.localise_only = true;
    return request;
  }

  static LocalisedFrames Places(std::vector<LocalisedFrame> frames) {
    LocalisedFrames localised;
    localised.frames = std::move(frames);
    return localised;
  }

  // Returns the session.
  uint64_t Open(const ShareScope& scope) {
    const auto opened = store_.OpenSession(Request(testing::kMission, scope));
    EXPECT_TRUE(opened.ok()) << opened.status();
    EXPECT_TRUE(opened->grant.capabilities.localise_only);
    return opened->session_id;
  }

  // Takes updates until there are no more.
  void TakeAll(uint64_t session) {
    while (true) {
      const auto update = store_.NextShared(session, kAll_bytes);
      ASSERT_TRUE(update.ok()) << update.status();
      if (!update->has_value()) return;
      mirror_.Apply(**update);
    }
  }

  Rigid3d PoseOf(KeyframeId id) {
    return store_.GetKeyframe(testing::kMission, id)->camera_from_island.ToRigid();
  }
  std::set<KeyframeId> SettledWithin(const Eigen::Vector3d& centre, double radius_m) {
    std::set<KeyframeId> ids;
    for (uint32_t i = 0; i < 11; ++i) {
      if ((CameraCentre(PoseOf(a_.Id(i))) - centre).norm() <= radius_m) ids.insert(a_.Id(i));
    }
    return ids;
  }
  std::set<KeyframeId> Held() const {
    std::set<KeyframeId> ids;
    for (const auto& [id, keyframe] : mirror_.keyframes) ids.insert(id);
    return ids;
  }
  AgentInfo Guest() {
    const auto agents = store_.ListAgents(testing::kMission, {});
    for (const AgentInfo& agent : agents->items) {
      if (agent.name == "guest") return agent;
    }
    ADD_FAILURE() << "no agent guest";
    return {};
  }

  TestAgent a_{store_, testing::kMission, "a", map_a_};
  testing::SharedMirror mirror_;
};

TEST_F(LocaliseOnlyTest, ItsFrameIsTheGlobalOneAndEverythingComesWithoutAMapOfItsOwn) {
  ASSERT_TRUE(a_.Stream().ok());
  const MissionInfo before = *store_.GetMission(testing::kMission);
  TakeAll(Open({ShareMode::kEverything}));
  ASSERT_TRUE(mirror_.global_from_local.has_value());
  EXPECT_TRUE(mirror_.global_from_local->ToRigid().translation.isZero(0));
  EXPECT_FALSE(mirror_.apart);
  EXPECT_EQ(mirror_.keyframes.size(), 11u);
  EXPECT_TRUE(mirror_.own.empty());
  for (const auto& [id, keyframe] : mirror_.keyframes) {
    EXPECT_LT(
        (CameraCentre(keyframe.camera_from_global.ToRigid()) - CameraCentre(PoseOf(id))).norm(),
        1e-9);
    for (const MapPointId& point : keyframe.points) {
      EXPECT_TRUE(!point.IsValid() || mirror_.points.contains(point)) << ToString(point);
    }
  }
  EXPECT_TRUE(Guest().up_to_date);
  const MissionInfo after = *store_.GetMission(testing::kMission);
  EXPECT_EQ(after.keyframes, before.keyframes);
  EXPECT_EQ(after.local_maps, before.local_maps);
  EXPECT_EQ(after.revision, before.revision);
}

TEST_F(LocaliseOnlyTest, WhatIsNearFollowsWhereItSaysThatItIs) {
  ASSERT_TRUE(a_.Stream().ok());
  const uint64_t session = Open(kNear);
  TakeAll(session);
  EXPECT_TRUE(mirror_.keyframes.empty()) << "it has not said where it is";
  const Rigid3d first = PoseOf(a_.Id(2));
  ASSERT_TRUE(store_.NoteLocalised(session, Places({{1, first}})).ok());
  TakeAll(session);
  std::set<KeyframeId> wanted = SettledWithin(CameraCentre(first), kNear.radius_m);
  ASSERT_GT(wanted.size(), 1u);
  ASSERT_LT(wanted.size(), 11u);
  EXPECT_EQ(Held(), wanted);
  // What was told stays when the robot moves on.
  const Rigid3d second = PoseOf(a_.Id(7));
  ASSERT_TRUE(store_.NoteLocalised(session, Places({{2, std::nullopt}, {3, second}})).ok());
  TakeAll(session);
  wanted.merge(SettledWithin(CameraCentre(second), kNear.radius_m));
  EXPECT_EQ(Held(), wanted);
  EXPECT_EQ(mirror_.restarts, 0);
}

TEST_F(LocaliseOnlyTest, ListAgentsHasWhatItSaid) {
  ASSERT_TRUE(a_.Stream().ok());
  const uint64_t session = Open(kNear);
  EXPECT_TRUE(Guest().localise_only);
  EXPECT_FALSE(Guest().last_pose.has_value());
  ASSERT_TRUE(store_.NoteLocalised(session, Places({{5, PoseOf(a_.Id(4))}})).ok());
  const auto pose = Guest().last_pose;
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->timestamp_ns, 5);
  EXPECT_FALSE(pose->local_map.IsValid());
  EXPECT_TRUE(pose->in_reference_island);
  EXPECT_FALSE(pose->lost_since);
  EXPECT_LT((CameraCentre(pose->camera_from_island) - CameraCentre(PoseOf(a_.Id(4)))).norm(), 1e-9);
  ASSERT_TRUE(store_.NoteLocalised(session, Places({{6, std::nullopt}})).ok());
  EXPECT_TRUE(Guest().last_pose->lost_since);
}

TEST_F(LocaliseOnlyTest, ItMayNotChangeTheMapAndOthersMayNotSayWhereTheyAre) {
  ASSERT_TRUE(a_.Stream().ok());
  MapUpdateBatch batch;
  batch.local_map = {77};
  batch.number = 1;
  const auto refused = store_.Apply(Open(kNear), batch);
  EXPECT_TRUE(absl::IsPermissionDenied(refused.status())) << refused.status();
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("localise_only"));
  const absl::Status noted =
      store_.NoteLocalised(a_.session(), Places({{1, Rigid3d::Identity()}})).status();
  EXPECT_TRUE(absl::IsPermissionDenied(noted)) << noted;
}

TEST_F(LocaliseOnlyTest, AMissionDoesNotBeginWithIt) {
  const auto opened = store_.OpenSession(Request("nowhere", kNear));
  EXPECT_TRUE(absl::IsNotFound(opened.status())) << opened.status();
  EXPECT_TRUE(absl::IsNotFound(store_.GetMission("nowhere").status()));
}

TEST_F(LocaliseOnlyTest, TheSameRobotMapsAgainLater) {
  ASSERT_TRUE(a_.Stream().ok());
  TakeAll(Open({ShareMode::kEverything}));
  SessionRequest request = Request(testing::kMission, {});
  request.localise_only = false;
  const auto opened = store_.OpenSession(request);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_FALSE(Guest().localise_only);
  EXPECT_FALSE(store_.NextShared(opened->session_id, kAll_bytes)->has_value());
}

}  // namespace
}  // namespace corbslam::map_store

// Tests that agents are told what they want to be told, and no more.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "map_store/testing/sharing_mission.h"

namespace corbslam::map_store {
namespace {

using testing::kMission;
using testing::SharedMirror;
using testing::SyntheticMap;
using testing::TestAgent;

// Everything that an update may have fits in.
constexpr size_t kAll_bytes = 100 << 20;
// The robots drive on a ring of 15 m, a keyframe every metre.
constexpr ShareScope kNear = {ShareMode::kNearby, 6};
constexpr ShareScope kCorrections = {ShareMode::kCorrections};
constexpr ShareScope kNone = {ShareMode::kNone};

using Ids = std::set<KeyframeId>;

class ShareScopeTest : public testing::SharingMission {
 protected:
  Eigen::Vector3d Centre(KeyframeId id) {
    return CameraCentre(store_.GetKeyframe(kMission, id)->camera_from_island.ToRigid());
  }
  // Returns A's keyframes that have settled and are near the newest one of the `sent` that B sent.
  Ids NearOnes(uint32_t sent, double radius_m = kNear.radius_m) {
    const Eigen::Vector3d robot = Centre(b_.Id(sent - 1));
    Ids ids;
    for (uint32_t i = 0; i < 11; ++i) {
      if ((Centre(a_.Id(i)) - robot).norm() <= radius_m) ids.insert(a_.Id(i));
    }
    return ids;
  }
  static Ids Held(const TestAgent& agent) {
    Ids ids;
    for (const auto& [id, keyframe] : agent.mirror().keyframes) ids.insert(id);
    return ids;
  }
  bool UpToDate(const std::string& name) {
    const auto agents = store_.ListAgents(kMission, {});
    for (const AgentInfo& agent : agents->items) {
      if (agent.name == name) return agent.up_to_date;
    }
    return false;
  }
  // Expects what the agent holds to be whole, and where the store says that it is.
  void ExpectSound(const TestAgent& agent) {
    const SharedMirror& mirror = agent.mirror();
    for (const auto& [id, keyframe] : mirror.keyframes) {
      EXPECT_LT((CameraCentre(keyframe.camera_from_global.ToRigid()) - Centre(id)).norm(), 1e-3)
          << ToString(id);
      for (const MapPointId& point : keyframe.points) {
        if (!point.IsValid() || point.local_map == agent.local_map()) continue;
        EXPECT_TRUE(mirror.points.contains(point)) << ToString(id) << " " << ToString(point);
      }
    }
  }
  // Expects the agent to hold what one holds that has heard nothing before.
  void ExpectAsFromScratch(const TestAgent& agent) {
    TestAgent newcomer(store_, kMission, agent.name(), agent.made());
    ASSERT_TRUE(newcomer.TakeShared(kAll_bytes).ok());
    ASSERT_EQ(Held(agent), Held(newcomer));
    for (const auto& [id, keyframe] : newcomer.mirror().keyframes) {
      EXPECT_EQ(agent.mirror().keyframes.at(id).points, keyframe.points) << ToString(id);
    }
    for (const auto& [id, point] : newcomer.mirror().points) {
      EXPECT_TRUE(agent.mirror().points.contains(id)) << ToString(id);
    }
    for (const auto& [survivor, members] : newcomer.mirror().landmarks) {
      const auto held = agent.mirror().landmarks.find(survivor);
      ASSERT_NE(held, agent.mirror().landmarks.end()) << ToString(survivor);
      EXPECT_EQ(held->second, members) << ToString(survivor);
      for (const MapPointId& member : members) EXPECT_FALSE(agent.mirror().points.contains(member));
    }
    EXPECT_EQ(agent.mirror().own.size(), newcomer.mirror().own.size());
  }

  void StreamAndFuse(const ShareScope& scope, size_t keyframes_of_b = 14) {
    ASSERT_TRUE(b_.Resume(scope).ok());
    ASSERT_TRUE(a_.Stream().ok());
    ASSERT_TRUE(b_.Stream(keyframes_of_b).ok());
    Fuse();
  }

  TestAgent a_{store_, kMission, "a", map_a_};
  TestAgent b_{store_, kMission, "b", map_b_};
};

TEST_F(ShareScopeTest, WhoWantsNothingIsToldNothingAndIsUpToDate) {
  StreamAndFuse(kNone);
  EXPECT_TRUE(UpToDate("b"));
  EXPECT_FALSE(store_.NextShared(b_.session(), kAll_bytes)->has_value());
  ASSERT_TRUE(a_.Close().ok());
  ASSERT_TRUE(b_.Close().ok());
  Fuse();
  EXPECT_FALSE(store_.NextShared(b_.session(), kAll_bytes)->has_value());
  EXPECT_TRUE(UpToDate("b"));
  EXPECT_FALSE(UpToDate("a")) << "it wants everything, and asked for nothing yet";
  ASSERT_TRUE(a_.TakeShared().ok());
  EXPECT_FALSE(a_.mirror().keyframes.empty()) << "what one wants is nothing to the others";
}

TEST_F(ShareScopeTest, CorrectionsAreWhereOwnKeyframesStand) {
  StreamAndFuse(kCorrections);
  EXPECT_FALSE(UpToDate("b"));
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_TRUE(UpToDate("b"));
  const SharedMirror& mirror = b_.mirror();
  EXPECT_EQ(mirror.own.size(), 11u);
  for (const auto& [id, pose] : mirror.own) {
    EXPECT_LT((CameraCentre(pose.ToRigid()) - Centre(id)).norm(), 1e-3);
  }
  EXPECT_EQ(mirror.revision, store_.GetStatistics(kMission)->revision);
  ASSERT_TRUE(a_.Close().ok());
  ASSERT_TRUE(b_.Close().ok());
  Fuse();
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_EQ(mirror.own.size(), 14u);
  EXPECT_TRUE(mirror.keyframes.empty());
  EXPECT_TRUE(mirror.points.empty());
  EXPECT_TRUE(mirror.landmarks.empty());
  EXPECT_EQ(mirror.restarts, 0);
}

TEST_F(ShareScopeTest, NearbyIsWithinTheRadiusOfTheNewestKeyframe) {
  StreamAndFuse(kNear, 5);
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  const Ids near = NearOnes(5);
  ASSERT_GT(near.size(), 1u);
  ASSERT_LT(near.size(), 10u);
  EXPECT_EQ(Held(b_), near);
  EXPECT_FALSE(b_.mirror().points.empty());
  EXPECT_TRUE(UpToDate("b"));
  ExpectSound(b_);
  EXPECT_FALSE(store_.NextShared(b_.session(), kAll_bytes)->has_value());
}

TEST_F(ShareScopeTest, SmallBudgetsComeToTheSameEnd) {
  StreamAndFuse(kNear, 5);
  ASSERT_TRUE(b_.TakeShared(5000).ok());
  EXPECT_GT(b_.mirror().updates, 3);
  EXPECT_EQ(Held(b_), NearOnes(5));
  ExpectSound(b_);
}

// A has driven the whole way before; B comes after it.
TEST_F(ShareScopeTest, WhatComesNearIsToldWhenTheRobotMovesOn) {
  const SyntheticMap behind = testing::MakeRingMap(0xd, 4, 11);
  testing::TruthfulWorker worker{{&map_a_, &behind}};
  MapStore store{testing::DeterministicOptions(), testing::TheWorld().vocabulary,
                 std::make_unique<InMemoryJournal>(), &worker};
  TestAgent a(store, kMission, "a", map_a_);
  TestAgent d(store, kMission, "d", behind);
  constexpr ShareScope kClose = {ShareMode::kNearby, 3};
  const auto centre = [&store](KeyframeId id) {
    return CameraCentre(store.GetKeyframe(kMission, id)->camera_from_island.ToRigid());
  };
  ASSERT_TRUE(d.Resume(kClose).ok());
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(d.Stream(4).ok());
  ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  Ids wanted;
  size_t first = 0;
  for (uint32_t sent = 4; sent <= 11; ++sent) {
    if (sent > 4) {
      ASSERT_TRUE(d.Stream(1).ok());
    }
    // Every other time fusion moves everything.
    if (sent % 2 == 0) {
      ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
    }
    ASSERT_TRUE(d.TakeShared(kAll_bytes).ok());
    for (uint32_t i = 0; i < 11; ++i) {
      if ((centre(a.Id(i)) - centre(d.Id(sent - 1))).norm() <= kClose.radius_m) {
        wanted.insert(a.Id(i));
      }
    }
    EXPECT_EQ(Held(d), wanted) << "after " << sent;
    if (sent == 4) first = wanted.size();
  }
  EXPECT_GT(first, 0u);
  EXPECT_GT(wanted.size(), first + 2) << "it met nothing on its way";
  EXPECT_EQ(d.mirror().restarts, 0);
}

TEST_F(ShareScopeTest, WhatWasToldOnceIsKeptUpToDate) {
  StreamAndFuse(kNear, 5);
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  const Ids before = Held(b_);
  const KeyframeId gone = *before.begin();
  const KeyframeId far = a_.Id(0);
  ASSERT_FALSE(before.contains(far));
  MapUpdateBatch batch = a_.EmptyBatch();
  batch.removed_keyframes.push_back({gone, a_.Id(gone.index - 1), Rigid3d::Identity()});
  ASSERT_TRUE(a_.Send(batch).ok());
  ASSERT_TRUE(b_.Stream().ok());
  ASSERT_TRUE(a_.Close().ok());
  ASSERT_TRUE(b_.Close().ok());
  Fuse();
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  const Ids after = Held(b_);
  EXPECT_FALSE(after.contains(gone));
  EXPECT_FALSE(after.contains(far));
  for (const KeyframeId& id : before) {
    EXPECT_TRUE(id == gone || after.contains(id)) << ToString(id);
  }
  ExpectSound(b_);
}

TEST_F(ShareScopeTest, WhoeverWantsMoreGetsWhatWasHeldBack) {
  StreamAndFuse(kNone);
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_EQ(b_.mirror().updates, 0);
  ASSERT_TRUE(b_.Resume(kCorrections).ok());
  EXPECT_FALSE(UpToDate("b"));
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_EQ(b_.mirror().own.size(), 11u);
  EXPECT_TRUE(Held(b_).empty());
  ShareScope near = kNear;
  for (const double radius_m : {12.0, 16.0}) {
    near.radius_m = radius_m;
    ASSERT_TRUE(b_.Resume(near).ok());
    ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
    EXPECT_EQ(Held(b_), NearOnes(14, radius_m)) << radius_m;
    EXPECT_LT(Held(b_).size(), 11u);
    ExpectSound(b_);
  }
  ASSERT_TRUE(b_.Resume({}).ok());
  EXPECT_FALSE(UpToDate("b"));
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_TRUE(UpToDate("b"));
  ExpectSound(b_);
  ExpectAsFromScratch(b_);
}

TEST_F(ShareScopeTest, WhoeverWantsLessKeepsWhatItHas) {
  StreamAndFuse({});
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  Ids held = Held(b_);
  ASSERT_EQ(held.size(), 11u);
  ASSERT_TRUE(b_.Resume(kCorrections).ok());
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_EQ(Held(b_), held);
  MapUpdateBatch batch = a_.EmptyBatch();
  batch.removed_keyframes.push_back({a_.Id(4), a_.Id(3), Rigid3d::Identity()});
  ASSERT_TRUE(a_.Send(batch).ok());
  // A's last keyframes settle with this.
  ASSERT_TRUE(a_.Close().ok());
  ASSERT_TRUE(b_.Close().ok());
  Fuse();
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  held.erase(a_.Id(4));
  EXPECT_EQ(Held(b_), held);
  EXPECT_EQ(b_.mirror().restarts, 0);
  ExpectSound(b_);
  ASSERT_TRUE(b_.Resume({}).ok());
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_EQ(Held(b_).size(), 13u);
  EXPECT_EQ(b_.mirror().restarts, 0);
  ExpectAsFromScratch(b_);
}

TEST_F(ShareScopeTest, AfterAPauseWithoutAnythingTheRestComes) {
  StreamAndFuse({});
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  const int updates = b_.mirror().updates;
  ASSERT_TRUE(b_.Resume(kNone).ok());
  MapUpdateBatch batch = a_.EmptyBatch();
  batch.removed_keyframes.push_back({a_.Id(4), a_.Id(3), Rigid3d::Identity()});
  ASSERT_TRUE(a_.Send(batch).ok());
  ASSERT_TRUE(a_.Close().ok());
  ASSERT_TRUE(b_.Close().ok());
  Fuse();
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_EQ(b_.mirror().updates, updates);
  ASSERT_TRUE(b_.Resume({}).ok());
  ASSERT_TRUE(b_.TakeShared(kAll_bytes).ok());
  EXPECT_EQ(b_.mirror().restarts, 0);
  ExpectSound(b_);
  ExpectAsFromScratch(b_);
}

TEST_F(ShareScopeTest, TheWishOutlivesAnotherFrame) {
  // B and C meet first, in B's frame; then A, who was first in the mission, meets B.
  TestAgent c(store_, kMission, "c", map_c_);
  ASSERT_TRUE(c.Resume(kCorrections).ok());
  ASSERT_TRUE(a_.Stream(4).ok());
  ASSERT_TRUE(b_.Stream().ok());
  ASSERT_TRUE(c.Stream().ok());
  Fuse();
  ASSERT_TRUE(c.TakeShared(kAll_bytes).ok());
  EXPECT_FALSE(c.mirror().own.empty());
  ASSERT_TRUE(a_.Stream().ok());
  ASSERT_TRUE(a_.Close().ok());
  Fuse();
  ASSERT_EQ(store_.GetStatistics(kMission)->islands, 1u);
  ASSERT_TRUE(c.TakeShared(kAll_bytes).ok());
  EXPECT_EQ(c.mirror().restarts, 1);
  EXPECT_FALSE(c.mirror().own.empty());
  EXPECT_TRUE(c.mirror().keyframes.empty());
  EXPECT_TRUE(c.mirror().points.empty());
}

}  // namespace
}  // namespace corbslam::map_store

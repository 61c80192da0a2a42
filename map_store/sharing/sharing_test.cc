// Tests what agents are sent of the map after fusion, and that it is no more than that.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "map_store/state/share_state.h"
#include "map_store/testing/sharing_mission.h"

namespace corbslam::map_store {
namespace {

using testing::DeterministicOptions;
using testing::kMission;
using testing::MakeRingMap;
using testing::SharedMirror;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

class SharingTest : public testing::SharingMission {
 protected:
  Similarity3d Pose(KeyframeId id) { return store_.GetKeyframe(kMission, id)->camera_from_island; }
  // Expects the mirror to hold what it needs, where the store says it is.
  void ExpectSound(const TestAgent& agent) {
    const SharedMirror& mirror = agent.mirror();
    for (const auto& [id, keyframe] : mirror.keyframes) {
      EXPECT_NE(id.local_map, agent.local_map());
      EXPECT_LT((keyframe.camera_from_global.translation - Pose(id).translation).norm(), 1e-4);
      for (const MapPointId& point : keyframe.points) {
        if (!point.IsValid() || point.local_map == agent.local_map()) continue;
        EXPECT_TRUE(mirror.points.contains(point)) << ToString(id) << " " << ToString(point);
      }
    }
    for (const auto& [id, pose] : mirror.own) {
      EXPECT_EQ(id.local_map, agent.local_map());
      EXPECT_LT((pose.translation - Pose(id).translation).norm(), 1e-4);
    }
  }
};

TEST_F(SharingTest, NothingBeforeFusionEverythingSettledAfterIt) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(a.TakeShared().ok());
  EXPECT_EQ(a.mirror().updates, 1) << "where it lies in the global frame (global_place_test.cc)";
  EXPECT_TRUE(a.mirror().own.empty());
  EXPECT_TRUE(a.mirror().keyframes.empty());
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().updates, 0);
  Fuse();
  ASSERT_TRUE(a.TakeShared().ok());
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(a.mirror().keyframes.size(), 11u);
  EXPECT_EQ(b.mirror().keyframes.size(), 11u);
  EXPECT_EQ(a.mirror().own.size(), 11u);
  EXPECT_EQ(b.mirror().own.size(), 11u);
  EXPECT_EQ(a.mirror().revision, store_.GetStatistics(kMission)->revision);
  ExpectSound(a);
  ExpectSound(b);
  // B learns which of its own points are one with A's.
  size_t own_members = 0;
  for (const auto& [survivor, members] : b.mirror().landmarks) {
    for (const MapPointId& member : members) {
      if (member.local_map == b.local_map()) ++own_members;
    }
  }
  EXPECT_GT(own_members, 20u);
  // Then there is nothing more to say.
  const int updates = b.mirror().updates;
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().updates, updates);
}

TEST_F(SharingTest, AnAgentThatComesLaterGetsTheMapOfOneThatHasGone) {
  TestAgent a(store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(a.Close().ok());
  store_.CloseSession(a.session());
  Fuse();
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(b.Stream(5).ok());
  Fuse();
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().keyframes.size(), 14u);
  ExpectSound(b);
}

TEST_F(SharingTest, ASmallBudgetTakesMoreStepsToTheSameEndNearestFirst) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  std::vector<KeyframeId> order;
  size_t updates = 0;
  while (true) {
    const auto update = store_.NextShared(b.session(), 10000);
    ASSERT_TRUE(update.ok());
    if (!update->has_value()) break;
    ASSERT_LT(++updates, 1000u);
    EXPECT_LE((*update)->keyframes.size(), 1u);
    for (const SharedKeyframe& keyframe : (*update)->keyframes) {
      order.push_back(keyframe.payload->id);
    }
  }
  EXPECT_GT(updates, 11u);
  ASSERT_EQ(order.size(), 11u);
  EXPECT_EQ(std::set<KeyframeId>(order.begin(), order.end()).size(), 11u);
  // B drives where A's way ends: the keyframes near that come first.
  EXPECT_GT(order.front().index, 5u);
  EXPECT_LT(order.back().index, 5u);
}

TEST_F(SharingTest, ListedAgentsAreUpToDateOnceAllWasTold) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  const auto find_b = [this] { return store_.ListAgents(kMission, {})->items.at(1); };
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  EXPECT_TRUE(find_b().up_to_date) << "nothing was merged yet";
  Fuse();
  uint64_t updates = 0;
  while (true) {
    EXPECT_FALSE(find_b().up_to_date);
    const auto update = store_.NextShared(b.session(), 10000);
    ASSERT_TRUE(update.ok());
    if (!update->has_value()) break;
    ++updates;
    EXPECT_EQ(find_b().shared_updates, updates);
    if (find_b().up_to_date) {
      EXPECT_FALSE(store_.NextShared(b.session(), 10000)->has_value()) << "it was the last one";
      break;
    }
  }
  EXPECT_GT(updates, 1u);
  EXPECT_TRUE(find_b().up_to_date);
  ASSERT_TRUE(a.Send(a.NextBatch(0)).ok());
  store_.CloseSession(b.session());
  EXPECT_FALSE(find_b().up_to_date) << "it is not connected";
}

TEST_F(SharingTest, LaterStepsCarryOnlyWhatChanged) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  ASSERT_TRUE(b.TakeShared().ok());
  MapUpdateBatch removal = a.EmptyBatch();
  removal.removed_keyframes.push_back({a.Id(4), a.Id(3), Rigid3d::Identity()});
  const MapPointId point = map_a_.map.points().begin()->first;
  removal.removed_points.push_back(point);
  ASSERT_TRUE(a.Send(removal).ok());
  auto update = store_.NextShared(b.session(), 1 << 20);
  ASSERT_TRUE(update.ok() && update->has_value());
  EXPECT_TRUE((*update)->keyframes.empty());
  EXPECT_THAT((*update)->removed_keyframes, ::testing::ElementsAre(a.Id(4)));
  EXPECT_THAT((*update)->removed_points, ::testing::ElementsAre(point));

  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
  Fuse();
  update = store_.NextShared(b.session(), 1 << 20);
  ASSERT_TRUE(update.ok() && update->has_value());
  // The update has only keyframes that have settled since, and none that B holds.
  for (const SharedKeyframe& keyframe : (*update)->keyframes) {
    EXPECT_GT(keyframe.payload->id.index, 10u);
  }
  EXPECT_GT((*update)->own_keyframes.size(), 0u);
}

TEST_F(SharingTest, AnotherFrameStartsAgain) {
  // B and C meet first, in B's frame; then A, who was first in the mission, meets B.
  TestAgent a(store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Stream(4).ok());
  TestAgent b(store_, kMission, "b", map_b_);
  TestAgent c(store_, kMission, "c", map_c_);
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(c.Stream().ok());
  Fuse();
  ASSERT_EQ(store_.GetStatistics(kMission)->islands, 2u);
  ASSERT_TRUE(c.TakeShared().ok());
  EXPECT_FALSE(c.mirror().keyframes.empty());
  EXPECT_EQ(c.mirror().restarts, 0);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(a.Close().ok());
  Fuse();
  ASSERT_EQ(store_.GetStatistics(kMission)->islands, 1u);
  ASSERT_TRUE(c.TakeShared().ok());
  EXPECT_EQ(c.mirror().restarts, 1);
  EXPECT_EQ(c.mirror().keyframes.size(), 14u + 11u);
  ExpectSound(c);
}

TEST_F(SharingTest, AResumedSessionGoesOnOrStartsAgain) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  ASSERT_TRUE(b.TakeShared(100 << 20).ok());
  SessionRequest request;
  request.mission = kMission;
  request.agent = "b";
  request.last_revision = b.mirror().revision;
  const auto certain = store_.OpenSession(request);
  EXPECT_FALSE(store_.NextShared(certain->session_id, 1 << 20)->has_value());
  request.last_revision = b.mirror().revision - 1;
  EXPECT_TRUE(store_.ListAgents(kMission, {})->items.at(1).up_to_date);
  const auto behind = store_.OpenSession(request);
  EXPECT_FALSE(store_.ListAgents(kMission, {})->items.at(1).up_to_date) << "nothing was told anew";
  const auto update = store_.NextShared(behind->session_id, 1 << 20);
  ASSERT_TRUE(update->has_value());
  EXPECT_TRUE((*update)->restart);
  EXPECT_FALSE((*update)->keyframes.empty());
}

TEST_F(SharingTest, WhatAnAgentWasToldTakesMemoryUntilItEndsItself) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  const auto memory = [this] { return store_.GetMission(kMission)->memory_bytes; };
  const uint64_t before = memory();
  ASSERT_TRUE(b.TakeShared(100 << 20).ok());
  const uint64_t told = memory();
  const uint64_t least = b.mirror().keyframes.size() * sizeof(SentKeyframe) +
                         b.mirror().points.size() * sizeof(MapPointId);
  EXPECT_GT(told, before + least);
  store_.CloseSession(b.session());
  EXPECT_EQ(memory(), told) << "its line broke: it comes again, and goes on";
  SessionRequest request;
  request.mission = kMission;
  request.agent = "b";
  request.last_revision = b.mirror().revision;
  const auto back = store_.OpenSession(request);
  EXPECT_FALSE(store_.NextShared(back->session_id, 1 << 20)->has_value());
  store_.CloseSession(back->session_id, /*on_purpose=*/true);
  EXPECT_LT(memory() + least, told);
  const auto again = store_.OpenSession(request);
  const auto update = store_.NextShared(again->session_id, 1 << 20);
  ASSERT_TRUE(update->has_value());
  EXPECT_TRUE((*update)->restart) << "nobody knows any more what it holds";
  EXPECT_FALSE((*update)->keyframes.empty());
}

// The point that stands for a replaced one may take the next one off the list of what the agent
// holds.
TEST_F(SharingTest, ReplacedPointsGoOnAsTheirLandmarks) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  TestAgent c(store_, kMission, "c", map_c_);
  for (TestAgent* agent : {&a, &b, &c}) {
    ASSERT_TRUE(agent->Stream().ok());
    ASSERT_TRUE(agent->Close().ok());
  }
  Fuse();
  ASSERT_TRUE(c.TakeShared().ok());
  std::vector<MapPointId> held;
  for (const auto& [id, point] : c.mirror().points) {
    if (id.local_map == a.local_map()) held.push_back(id);
  }
  ASSERT_GT(held.size(), 20u);
  MapUpdateBatch batch = a.EmptyBatch();
  for (size_t i = 0; i + 1 < held.size(); i += 2) {
    batch.replacements.push_back({held[i], held[i + 1]});
  }
  ASSERT_TRUE(a.Send(batch).ok());
  Fuse();
  ASSERT_TRUE(c.TakeShared().ok());
  ExpectSound(c);
  const int updates = c.mirror().updates;
  ASSERT_TRUE(c.TakeShared().ok());
  EXPECT_EQ(c.mirror().updates, updates);
}

// What was said step by step must be the same as what an agent is told that has heard nothing.
class StepByStepTest : public SharingTest {
 protected:
  StepByStepTest() {
    a_ = std::make_unique<TestAgent>(store_, kMission, "a", map_a_);
    b_ = std::make_unique<TestAgent>(store_, kMission, "b", map_b_);
    c_ = std::make_unique<TestAgent>(store_, kMission, "c", map_c_);
  }

  // The other agents hear of each step by itself. In the end they, and newcomers of their names,
  // hold the same.
  void Hear() {
    for (TestAgent* agent : {a_.get(), b_.get(), c_.get()}) ASSERT_TRUE(agent->TakeShared().ok());
  }
  void ExpectAsFromScratch() {
    Hear();
    ExpectAsFromScratch(*b_, "b", map_b_);
    ExpectAsFromScratch(*c_, "c", map_c_);
  }
  void ExpectAsFromScratch(const TestAgent& agent, const std::string& name,
                           const SyntheticMap& made) {
    TestAgent newcomer(store_, kMission, name, made);
    ASSERT_TRUE(newcomer.TakeShared().ok());
    const SharedMirror& told = agent.mirror();
    const SharedMirror& all = newcomer.mirror();
    ASSERT_FALSE(all.keyframes.empty());
    EXPECT_EQ(Keys(told.keyframes), Keys(all.keyframes));
    for (const auto& [id, keyframe] : all.keyframes) {
      const SharedKeyframe& other = told.keyframes.at(id);
      EXPECT_EQ(keyframe.points, other.points) << ToString(id);
      EXPECT_LT(
          (keyframe.camera_from_global.translation - other.camera_from_global.translation).norm(),
          1e-4);
    }
    for (const auto& [id, point] : all.points) {
      const auto other = told.points.find(id);
      ASSERT_NE(other, told.points.end()) << ToString(id);
      EXPECT_LT((point.position_in_global - other->second.position_in_global).norm(), 2e-3);
    }
    // Both know each landmark by the same name, and by no other.
    for (const auto& [survivor, members] : all.landmarks) {
      ASSERT_TRUE(told.landmarks.contains(survivor)) << ToString(survivor);
      EXPECT_EQ(told.landmarks.at(survivor), members) << ToString(survivor);
      for (const MapPointId& member : members) EXPECT_FALSE(told.points.contains(member));
    }
  }
  template <typename Items>
  static std::set<typename Items::key_type> Keys(const Items& items) {
    std::set<typename Items::key_type> keys;
    for (const auto& [id, item] : items) keys.insert(id);
    return keys;
  }

  void FuseAll() {
    for (TestAgent* agent : {a_.get(), b_.get(), c_.get()}) ASSERT_TRUE(agent->Stream(9).ok());
    Fuse();
    Hear();
    ASSERT_EQ(store_.GetStatistics(kMission)->islands, 1u);
  }
  // Returns A's points that B was sent; those that are landmarks with others' points come first.
  std::vector<MapPointId> HeldOfA() const {
    std::vector<MapPointId> held;
    for (const auto& [survivor, members] : b_->mirror().landmarks) {
      if (survivor.local_map == a_->local_map()) held.push_back(survivor);
    }
    for (const auto& [id, point] : b_->mirror().points) {
      const bool listed = std::find(held.begin(), held.end(), id) != held.end();
      if (id.local_map == a_->local_map() && !listed) held.push_back(id);
    }
    return held;
  }

  std::unique_ptr<TestAgent> a_, b_, c_;
};

TEST_F(StepByStepTest, NewKeyframes) {
  FuseAll();
  for (int i = 0; i < 4; ++i) {
    for (TestAgent* agent : {a_.get(), b_.get(), c_.get()}) ASSERT_TRUE(agent->Stream(1).ok());
    Hear();
  }
  ExpectAsFromScratch();
}

TEST_F(StepByStepTest, MovedKeyframesAndPoints) {
  FuseAll();
  ASSERT_TRUE(a_->Stream(2).ok());
  Hear();
  MapUpdateBatch batch = a_->EmptyBatch();
  for (const auto& [id, keyframe] : map_a_.map.keyframes()) {
    if (id.index < 5 || id.index > 10) continue;
    Rigid3d pose = keyframe.camera_from_map;
    pose.translation.x() += 0.01 * id.index;
    batch.light_keyframes.push_back({id, pose, keyframe.parent});
  }
  for (const MapPointId& id : HeldOfA()) {
    batch.light_points.push_back(
        {id, map_a_.map.FindPoint(id)->position_in_map + Eigen::Vector3d(0.05, 0, 0)});
  }
  ASSERT_TRUE(a_->Send(batch).ok());
  // A move alone is no reason for a message; the next keyframe is.
  ASSERT_TRUE(a_->Stream(1).ok());
  ExpectAsFromScratch();
}

TEST_F(StepByStepTest, RemovedAndReplacedPoints) {
  FuseAll();
  const std::vector<MapPointId> held = HeldOfA();
  ASSERT_GT(held.size(), 40u);
  MapUpdateBatch batch = a_->EmptyBatch();
  for (size_t i = 0; i < 10; ++i) batch.removed_points.push_back(held[i]);
  ASSERT_TRUE(a_->Send(batch).ok());
  Hear();
  batch = a_->EmptyBatch();
  for (size_t i = 10; i < 20; i += 2) batch.replacements.push_back({held[i], held[i + 1]});
  // This point is replaced by another robot's.
  const MapPointId foreign = map_b_.map.points().begin()->first;
  batch.replacements.push_back({held[20], foreign});
  ASSERT_TRUE(a_->Send(batch).ok());
  ExpectAsFromScratch();
}

// Two robots each say that the other's point stands for their own; fusion had made one of the two
// points one with a third robot's.
TEST_F(StepByStepTest, PointsThatReplaceEachOther) {
  FuseAll();
  MapPointId of_b;
  for (const auto& [survivor, members] : c_->mirror().landmarks) {
    if (survivor.local_map != a_->local_map()) continue;
    for (const MapPointId& member : members) {
      if (member.local_map == b_->local_map()) of_b = member;
    }
  }
  ASSERT_TRUE(of_b.IsValid()) << "fusion merged nothing";
  KeyframeId sees_it;
  for (const auto& [id, keyframe] : map_b_.map.keyframes()) {
    const auto& points = keyframe.points;
    if (id.index < 9 && std::find(points.begin(), points.end(), of_b) != points.end()) sees_it = id;
  }
  ASSERT_TRUE(sees_it.IsValid());
  const size_t before = store_.GetKeyframe(kMission, sees_it)->observed_points;
  const MapPointId of_c = map_c_.map.points().begin()->first;
  MapUpdateBatch batch = c_->EmptyBatch();
  batch.replacements = {{of_c, of_b}};
  ASSERT_TRUE(c_->Send(batch).ok());
  batch = b_->EmptyBatch();
  batch.replacements = {{of_b, of_c}};
  ASSERT_TRUE(b_->Send(batch).ok());
  EXPECT_EQ(store_.GetKeyframe(kMission, sees_it)->observed_points, before);
  ExpectAsFromScratch();
}

TEST_F(StepByStepTest, RemovedKeyframesAndObservations) {
  FuseAll();
  MapUpdateBatch batch = a_->EmptyBatch();
  batch.removed_keyframes.push_back({a_->Id(4), a_->Id(3), Rigid3d::Identity()});
  const auto& [point, seen] = *map_a_.map.points().begin();
  const auto& [keyframe, keypoint] = *seen.observations.begin();
  batch.observations.push_back({ObservationChange::Kind::kRemoved, point, keyframe, keypoint});
  ASSERT_TRUE(a_->Send(batch).ok());
  ExpectAsFromScratch();
}

TEST_F(StepByStepTest, FurtherFusing) {
  FuseAll();
  for (TestAgent* agent : {a_.get(), b_.get(), c_.get()}) {
    ASSERT_TRUE(agent->Stream(3).ok());
    Fuse();
    Hear();
  }
  for (TestAgent* agent : {a_.get(), b_.get(), c_.get()}) ASSERT_TRUE(agent->Close().ok());
  Fuse();
  ExpectAsFromScratch();
}

TEST_F(StepByStepTest, RetractionBetweenTwoLooks) {
  FuseAll();
  OverlapFilter filter;
  filter.accepted = true;
  const auto accepted = store_.ListOverlaps(kMission, filter, {})->items;
  ASSERT_FALSE(accepted.empty());
  ASSERT_TRUE(store_.RetractOverlap(kMission, accepted.front().id, false).ok());
  Fuse();
  ExpectAsFromScratch();
}

TEST(SharingAtOnceTest, ProvisionalKeyframesToo) {
  const SyntheticMap map_a = MakeRingMap(0xa, 0, 14);
  const SyntheticMap map_b = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker{{&map_a, &map_b}};
  MapStoreOptions options = DeterministicOptions();
  options.share_after = 0;
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker);
  TestAgent a(store, kMission, "a", map_a);
  TestAgent b(store, kMission, "b", map_b);
  ASSERT_TRUE(a.Stream(11).ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().keyframes.size(), 11u);
  ASSERT_TRUE(a.Stream(1).ok());
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().keyframes.size(), 12u);
  // The keyframe follows its robot as long as fusion has not placed it.
  MapUpdateBatch move = a.EmptyBatch();
  const Keyframe& newest = *map_a.map.FindKeyframe(a.Id(11));
  Rigid3d moved = newest.camera_from_map;
  moved.translation.x() += 0.5;
  move.light_keyframes.push_back({newest.id(), moved, newest.parent});
  ASSERT_TRUE(a.Send(move).ok());
  ASSERT_TRUE(a.Stream(1).ok());
  const Similarity3d before = b.mirror().keyframes.at(a.Id(11)).camera_from_global;
  ASSERT_TRUE(b.TakeShared().ok());
  const Similarity3d after = b.mirror().keyframes.at(a.Id(11)).camera_from_global;
  EXPECT_NEAR((after.translation - before.translation).norm(), 0.5, 0.05);
}

TEST_F(StepByStepTest, AMapThatIsKeptApartFromNowOn) {
  FuseAll();
  OverlapFilter filter;
  filter.accepted = true;
  filter.local_map = c_->local_map();
  const auto with_c = store_.ListOverlaps(kMission, filter, {})->items;
  ASSERT_FALSE(with_c.empty());
  for (const OverlapInfo& overlap : with_c) {
    store_.RetractOverlap(kMission, overlap.id, true).IgnoreError();
  }
  Fuse();
  ASSERT_EQ(store_.GetStatistics(kMission)->islands, 2u);
  Hear();
  for (const TestAgent* agent : {a_.get(), b_.get()}) {
    EXPECT_FALSE(agent->mirror().keyframes.empty());
    for (const auto& [id, keyframe] : agent->mirror().keyframes) {
      EXPECT_NE(id.local_map, c_->local_map());
    }
  }
  EXPECT_TRUE(c_->mirror().keyframes.empty());
}

TEST_F(SharingTest, ListenersHearOfARevision) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  int calls = 0;
  // A listener may call the store.
  store_.SetSharedListener(a.session(), [&] {
    ++calls;
    EXPECT_TRUE(a.TakeShared().ok());
  });
  ASSERT_TRUE(a.Stream().ok());
  EXPECT_EQ(calls, 1) << "of its own batches only the first keyframe's is news";
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  EXPECT_GT(calls, 1);
  EXPECT_EQ(a.mirror().keyframes.size(), 11u);
}

}  // namespace
}  // namespace corbslam::map_store

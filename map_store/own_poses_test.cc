// What robots are told of their own keyframes: where fusion placed them, and from which local pose.
#include <gtest/gtest.h>

#include <map>
#include <memory>

#include "map_store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam {
namespace {

using testing::DeterministicOptions;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";

class OwnPosesTest : public ::testing::Test {
 protected:
  void Fuse() { ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok()); }

  // By keyframe, of all updates that wait.
  std::map<KeyframeId, OwnKeyframePose> TakeOwnPoses(const TestAgent& agent) {
    std::map<KeyframeId, OwnKeyframePose> told;
    while (true) {
      const auto update = store_.NextShared(agent.session(), 1 << 20);
      EXPECT_TRUE(update.ok()) << update.status();
      if (!update.ok() || !update->has_value()) return told;
      for (const OwnKeyframePose& pose : (*update)->own_keyframes) told[pose.id] = pose;
    }
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  MapStore store_{DeterministicOptions(), TheWorld().vocabulary,
                  std::make_unique<InMemoryJournal>(), &worker_};
};

TEST_F(OwnPosesTest, AreToldWithTheLocalPosesThatTheyWereDerivedFrom) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  const auto told = TakeOwnPoses(b);
  EXPECT_EQ(told.size(), 11U);
  for (const auto& [id, pose] : told) {
    EXPECT_LT((pose.camera_from_local.translation -
               map_b_.map.FindKeyframe(id)->camera_from_map.translation)
                  .norm(),
              1e-12);
  }
}

TEST_F(OwnPosesTest, AreToldAgainWhenTheyAreDerivedFromOtherLocalPoses) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  const auto before = TakeOwnPoses(b);
  // The robot's frame goes elsewhere, its map keeps its shape: nothing moves in the global frame.
  const Rigid3d shift = {Eigen::Quaterniond::Identity(), {0.3, 0, 0}};
  MapUpdateBatch moved = b.EmptyBatch();
  for (const auto& [id, keyframe] : map_b_.map.keyframes()) {
    moved.light_keyframes.push_back({id, keyframe.camera_from_map * shift, keyframe.parent});
  }
  moved.loop_edges.push_back({b.Id(10), b.Id(0), Similarity3d()});
  ASSERT_TRUE(b.Send(moved).ok());
  EXPECT_TRUE(TakeOwnPoses(b).empty()) << "nothing was derived from them yet";
  Fuse();
  const auto after = TakeOwnPoses(b);
  ASSERT_FALSE(after.empty());
  for (const auto& [id, pose] : after) {
    const Rigid3d local = before.at(id).camera_from_local * shift;
    EXPECT_LT((pose.camera_from_local.translation - local.translation).norm(), 1e-9)
        << ToString(id);
  }
}

}  // namespace
}  // namespace corbslam

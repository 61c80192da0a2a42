// Tests what robots are told of places: where fusion put their own keyframes, from which local
// pose, and when all that moved is told.
#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "map_store/testing/sharing_mission.h"

namespace corbslam::map_store {
namespace {

using testing::kMission;
using testing::TestAgent;

class ToldPlacesTest : public testing::SharingMission {
 protected:
  // Takes all updates that wait, and returns their poses of own keyframes.
  std::map<KeyframeId, OwnKeyframePose> TakeOwnPoses(const TestAgent& agent) {
    std::map<KeyframeId, OwnKeyframePose> told;
    while (true) {
      const auto update = store_.NextShared(agent.session(), 1 << 20);
      EXPECT_TRUE(update.ok()) << update.status();
      if (!update.ok() || !update->has_value()) return told;
      for (const OwnKeyframePose& pose : (*update)->own_keyframes) told[pose.id] = pose;
    }
  }
};

TEST_F(ToldPlacesTest, OwnOnesComeWithTheLocalPosesThatTheyWereDerivedFrom) {
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

TEST_F(ToldPlacesTest, AnUpdateNamesTheLocalMapThatItIsOf) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  const auto alone = store_.NextShared(a.session(), 1 << 20);
  ASSERT_TRUE(alone.ok() && alone->has_value()) << alone.status();
  EXPECT_EQ((*alone)->local_map, a.Id(0).local_map);
  Fuse();
  const auto merged = store_.NextShared(b.session(), 1 << 20);
  ASSERT_TRUE(merged.ok() && merged->has_value()) << merged.status();
  EXPECT_EQ((*merged)->local_map, b.Id(0).local_map);
}

TEST_F(ToldPlacesTest, OwnOnesAreToldAgainWhenTheyAreDerivedFromOtherLocalPoses) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  const auto before = TakeOwnPoses(b);
  // The robot's frame goes elsewhere, but its map keeps its shape: nothing moves in the global
  // frame.
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

TEST_F(ToldPlacesTest, AnUpdateSaysWhetherAllThatMovedIsTold) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  // An update has room for about four of the eleven own keyframes.
  std::vector<bool> more_places;
  size_t own_keyframes = 0;
  while (own_keyframes < 11) {
    const auto update = store_.NextShared(b.session(), 600);
    ASSERT_TRUE(update.ok() && update->has_value());
    EXPECT_TRUE((*update)->keyframes.empty() || !(*update)->more_places);
    own_keyframes += (*update)->own_keyframes.size();
    more_places.push_back((*update)->more_places);
  }
  ASSERT_GE(more_places.size(), 3U);
  for (size_t i = 0; i + 1 < more_places.size(); ++i) EXPECT_TRUE(more_places[i]) << i;
  EXPECT_FALSE(more_places.back());
  // New keyframes are told in pieces, too, but each piece fits the places that B holds.
  while (true) {
    const auto update = store_.NextShared(b.session(), 10000);
    ASSERT_TRUE(update.ok());
    if (!update->has_value()) break;
    EXPECT_FALSE((*update)->more_places);
  }
}

}  // namespace
}  // namespace corbslam::map_store

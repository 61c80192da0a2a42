// Tests what watchers hold after each piece against the whole map as it is.
#include "map_store/view/map_watcher.h"

#include <string>

#include "map_store/testing/map_mirror.h"
#include "map_store/testing/two_robots.h"

namespace corbslam::map_store {
namespace {

using testing::MapMirror;

// Follows one store's map.
class Follower {
 public:
  Follower(size_t max_items, bool include_points)
      : max_items_(max_items), mirror_(include_points), watcher_(0, include_points) {}

  // Takes all pieces of one change. Returns how many keyframes and points they named.
  size_t Follow(const MapStore& store, const std::string& mission) {
    size_t items = 0;
    while (const auto changes = *store.NextChanges(mission, max_items_, watcher_)) {
      for (const MapChanges::Island& island : changes->islands) {
        EXPECT_LE(island.keyframes.size() + island.points.size(), max_items_);
      }
      items += mirror_.Apply(*changes);
    }
    return items;
  }

  void ExpectEquals(const MapStore& store, const std::string& mission) const {
    mirror_.ExpectEquals(*store.GlobalMapView(mission));
  }

  uint64_t version() const { return mirror_.version(); }

 private:
  const size_t max_items_;
  MapMirror mirror_;
  MapWatcher watcher_;
};

class MapWatcherTest : public testing::TwoRobots {
 protected:
  // Checks all watchers, whatever the size of pieces, and whoever came late or skipped changes.
  void Check() {
    SCOPED_TRACE(++checks_);
    for (Follower* mirror : {&all_, &few_, &poses_}) {
      mirror->Follow(store_, kMission);
      mirror->ExpectEquals(store_, kMission);
    }
    if (checks_ % 3 == 0) {
      seldom_.Follow(store_, kMission);
      seldom_.ExpectEquals(store_, kMission);
    }
    Follower late(50, true);
    late.Follow(store_, kMission);
    late.ExpectEquals(store_, kMission);
  }

  Follower all_{1000000, true};
  Follower few_{7, true};
  Follower poses_{100, false};
  Follower seldom_{1000, true};
  int checks_ = 0;
};

TEST_F(MapWatcherTest, HoldsTheMapThroughAllThatHappensToIt) {
  for (int k = 0; k < 12; ++k) {
    ASSERT_TRUE(a_.Stream(1).ok());
    ASSERT_TRUE(b_.Stream(1).ok());
    if (k % 4 == 3) Check();
  }
  Fuse();
  Check();
  ASSERT_EQ(Statistics().islands, 1u);
  MapUpdateBatch moves = b_.EmptyBatch();
  const Keyframe& moved = *map_b_.map.FindKeyframe(b_.Id(11));
  Rigid3d pose = moved.camera_from_map;
  pose.translation.x() += 0.01;
  moves.light_keyframes = {{b_.Id(11), pose, b_.Id(10)}};
  ASSERT_TRUE(b_.Send(moves).ok());
  Check();
  MapUpdateBatch removal = a_.EmptyBatch();
  removal.removed_keyframes = {{a_.Id(7), a_.Id(6),
                                map_a_.map.FindKeyframe(a_.Id(6))->camera_from_map *
                                    map_a_.map.FindKeyframe(a_.Id(7))->camera_from_map.Inverse()}};
  ASSERT_TRUE(a_.Send(removal).ok());
  Check();
  ASSERT_TRUE(a_.Stream(2).ok());
  Fuse();
  Check();
  uint64_t accepted = 0;
  const auto overlaps = store_.ListOverlaps(kMission, {}, {});
  for (const OverlapInfo& overlap : overlaps->items) {
    if (overlap.overlap.IsAccepted()) accepted = overlap.id;
  }
  ASSERT_NE(accepted, 0u);
  ASSERT_TRUE(store_.RetractOverlap(kMission, accepted, true).ok());
  Check();
  CloseBoth();
  Fuse();
  Check();
  ASSERT_TRUE(store_.RederiveGlobalLayer(kMission).ok());
  Check();
  Fuse();
  Check();
}

TEST_F(MapWatcherTest, OneKeyframeMoreIsToldAlone) {
  ASSERT_TRUE(a_.Stream(9).ok());
  poses_.Follow(store_, kMission);
  ASSERT_TRUE(a_.Stream(1).ok());
  // The changes are its new keyframes, and those that they make old enough for other robots.
  EXPECT_LE(poses_.Follow(store_, kMission), 4u);
  EXPECT_EQ(poses_.Follow(store_, kMission), 0u);
}

TEST_F(MapWatcherTest, WhoComesBackIsToldWhatChangedSince) {
  ASSERT_TRUE(a_.Stream(5).ok());
  ASSERT_TRUE(b_.Stream(5).ok());
  poses_.Follow(store_, kMission);
  MapWatcher again(poses_.version(), false);
  EXPECT_FALSE(store_.NextChanges(kMission, 100, again)->has_value());
  ASSERT_TRUE(b_.Stream(1).ok());
  const auto changes = *store_.NextChanges(kMission, 100, again);
  ASSERT_TRUE(changes.has_value());
  ASSERT_EQ(changes->islands.size(), 1u);
  EXPECT_EQ(changes->islands[0].id, b_.local_map());
  EXPECT_TRUE(changes->islands[0].anew) << "what is known of it is not known here";
  EXPECT_EQ(changes->islands[0].keyframes.size(), 6u);
}

}  // namespace
}  // namespace corbslam::map_store

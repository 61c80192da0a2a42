// Tests what watchers hold after each piece against the whole map as it is.
#include "map_store/view/map_watcher.h"

#include <map>
#include <set>
#include <string>
#include <utility>

#include "map_store/testing/two_robots.h"

namespace corbslam::map_store {
namespace {

using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;

// Keeps what a program that follows the stream keeps.
class Mirror {
 public:
  Mirror(size_t max_items, bool include_points)
      : max_items_(max_items), include_points_(include_points), watcher_(0, include_points) {}

  // Takes all pieces of one change. Returns how many keyframes and points they named.
  size_t Follow(const MapStore& store, const std::string& mission) {
    size_t items = 0;
    while (const auto changes = *store.NextChanges(mission, max_items_, watcher_)) {
      EXPECT_GE(changes->version, version_);
      version_ = changes->version;
      for (const IslandId id : changes->removed_islands) islands_.erase(id);
      for (const MapChanges::Island& island : changes->islands) {
        EXPECT_LE(island.keyframes.size() + island.points.size(), max_items_);
        items += Apply(island);
      }
    }
    return items;
  }

  void ExpectEquals(const MapStore& store, const std::string& mission) const {
    const auto views = store.GlobalMapView(mission);
    ASSERT_EQ(islands_.size(), views->size());
    for (const IslandView& view : *views) {
      const auto it = islands_.find(view.id);
      ASSERT_NE(it, islands_.end()) << ToString(view.id);
      const Island& island = it->second;
      EXPECT_EQ(island.local_maps, view.local_maps);
      EXPECT_EQ(island.keyframes.size(), view.keyframes.size());
      for (const IslandView::KeyframePlace& place : view.keyframes) {
        const auto found = island.keyframes.find(place.id);
        ASSERT_NE(found, island.keyframes.end()) << ToString(place.id);
        EXPECT_EQ(found->second.parent, place.parent);
        EXPECT_EQ(found->second.placed, place.placed) << ToString(place.id);
        EXPECT_EQ(found->second.camera_from_island.translation,
                  place.camera_from_island.translation);
      }
      if (!include_points_) continue;
      for (const IslandView::Point& point : view.points) {
        const auto found = island.points.find(point.id);
        ASSERT_NE(found, island.points.end()) << ToString(point.id);
        EXPECT_LT((found->second - point.position_in_island).norm(), 1e-12) << ToString(point.id);
      }
      // Points that nobody sees any more are in no view, but were not said to be gone either.
      EXPECT_LT(island.points.size(), view.points.size() + 20);
    }
  }

  uint64_t version() const { return version_; }

 private:
  struct Island {
    std::vector<LocalMapId> local_maps;
    std::map<KeyframeId, IslandView::KeyframePlace> keyframes;
    std::map<MapPointId, Eigen::Vector3d> points;
  };

  size_t Apply(const MapChanges::Island& changes) {
    if (changes.anew) islands_.erase(changes.id);
    Island& island = islands_[changes.id];
    island.local_maps = changes.local_maps;
    EXPECT_EQ(changes.agents.size(), changes.local_maps.size());
    for (const auto& keyframe : changes.keyframes) {
      island.keyframes.insert_or_assign(keyframe.id, keyframe);
    }
    for (const KeyframeId id : changes.removed_keyframes) island.keyframes.erase(id);
    for (const auto& [id, position] : changes.points) island.points[id] = position;
    for (const MapPointId id : changes.removed_points) island.points.erase(id);
    return changes.keyframes.size() + changes.points.size();
  }

  const size_t max_items_;
  const bool include_points_;
  MapWatcher watcher_;
  uint64_t version_ = 0;
  std::map<IslandId, Island> islands_;
};

class MapWatcherTest : public testing::TwoRobots {
 protected:
  // Checks all watchers, whatever the size of pieces, and whoever came late or skipped changes.
  void Check() {
    SCOPED_TRACE(++checks_);
    for (Mirror* mirror : {&all_, &few_, &poses_}) {
      mirror->Follow(store_, kMission);
      mirror->ExpectEquals(store_, kMission);
    }
    if (checks_ % 3 == 0) {
      seldom_.Follow(store_, kMission);
      seldom_.ExpectEquals(store_, kMission);
    }
    Mirror late(50, true);
    late.Follow(store_, kMission);
    late.ExpectEquals(store_, kMission);
  }

  Mirror all_{1000000, true};
  Mirror few_{7, true};
  Mirror poses_{100, false};
  Mirror seldom_{1000, true};
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

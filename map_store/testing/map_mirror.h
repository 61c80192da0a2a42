// What a program that follows the map keeps of it, to be held against the whole map.
#ifndef CORBSLAM_MAP_STORE_TESTING_MAP_MIRROR_H_
#define CORBSLAM_MAP_STORE_TESTING_MAP_MIRROR_H_

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "map_store/state/lookups.h"

namespace corbslam::testing {

class MapMirror {
 public:
  explicit MapMirror(bool include_points) : include_points_(include_points) {}

  // Takes the next piece. Returns how many keyframes and points it names.
  size_t Apply(const map_store::MapChanges& changes) {
    EXPECT_GE(changes.version, version_);
    version_ = changes.version;
    size_t items = 0;
    for (const map_store::IslandId id : changes.removed_islands) islands_.erase(id);
    for (const map_store::MapChanges::Island& island : changes.islands) items += Apply(island);
    return items;
  }

  // Expects that all pieces so far are the whole map.
  void ExpectEquals(const std::vector<map_store::IslandView>& views) const {
    ASSERT_EQ(islands_.size(), views.size());
    for (const map_store::IslandView& view : views) {
      const auto it = islands_.find(view.id);
      ASSERT_NE(it, islands_.end()) << ToString(view.id);
      EXPECT_EQ(it->second.local_maps, view.local_maps);
      ExpectKeyframes(it->second, view);
      if (include_points_) ExpectPoints(it->second, view);
    }
  }

  uint64_t version() const { return version_; }
  size_t CountKeyframes() const {
    size_t count = 0;
    for (const auto& [id, island] : islands_) count += island.keyframes.size();
    return count;
  }

 private:
  struct Island {
    std::vector<LocalMapId> local_maps;
    std::map<KeyframeId, map_store::IslandView::KeyframePlace> keyframes;
    std::map<MapPointId, Eigen::Vector3d> points;
  };

  // What is not told is a pixel in the pictures of the test's cameras (view/visible_motion.h),
  // for who came late up to two of them: at most so much close by, and a few times that farther
  // off.
  static constexpr double kUnseen_m = 0.09;
  static constexpr double kUnseen_rad = 0.007;

  static void ExpectKeyframes(const Island& island, const map_store::IslandView& view) {
    EXPECT_EQ(island.keyframes.size(), view.keyframes.size());
    for (const auto& place : view.keyframes) {
      const auto found = island.keyframes.find(place.id);
      ASSERT_NE(found, island.keyframes.end()) << ToString(place.id);
      EXPECT_EQ(found->second.parent, place.parent);
      EXPECT_EQ(found->second.placed, place.placed) << ToString(place.id);
      const Rigid3d motion = found->second.camera_from_island * place.camera_from_island.Inverse();
      EXPECT_LT(motion.translation.norm(), kUnseen_m) << ToString(place.id);
      EXPECT_LT(RotationAngle(motion.rotation), kUnseen_rad) << ToString(place.id);
    }
  }

  static void ExpectPoints(const Island& island, const map_store::IslandView& view) {
    for (const auto& point : view.points) {
      const auto found = island.points.find(point.id);
      ASSERT_NE(found, island.points.end()) << ToString(point.id);
      EXPECT_LT((found->second - point.position_in_island).norm(), 3 * kUnseen_m)
          << ToString(point.id);
    }
    // Points that nobody sees any more are in no view, but were not said to be gone either.
    EXPECT_LT(island.points.size(), view.points.size() + 20);
  }

  size_t Apply(const map_store::MapChanges::Island& changes) {
    if (changes.anew) islands_.erase(changes.id);
    Island& island = islands_[changes.id];
    island.local_maps = changes.local_maps;
    EXPECT_EQ(changes.agents.size(), changes.local_maps.size());
    for (const auto& keyframe : changes.keyframes) {
      island.keyframes.insert_or_assign(keyframe.id, keyframe);
    }
    for (const KeyframeId id : changes.removed_keyframes) island.keyframes.erase(id);
    for (const auto& point : changes.points) {
      EXPECT_GT(point.observations, 0u) << ToString(point.id);
      island.points[point.id] = point.position_in_island;
    }
    for (const MapPointId id : changes.removed_points) island.points.erase(id);
    return changes.keyframes.size() + changes.points.size();
  }

  const bool include_points_;
  uint64_t version_ = 0;
  std::map<map_store::IslandId, Island> islands_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_MAP_MIRROR_H_

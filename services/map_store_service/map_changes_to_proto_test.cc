#include "services/map_store_service/map_changes_to_proto.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "services/convert/ids.h"
#include "services/convert/limits.h"

namespace corbslam::services {
namespace {

using map_store::MapChanges;
using ::testing::ElementsAre;

// Items keep the names of the local maps that they were made in.
TEST(MapChangesToProtoTest, ItemsOfPartsHaveTheirAgent) {
  MapChanges changes;
  MapChanges::Island& island = changes.islands.emplace_back();
  island.id = {1};
  island.local_maps = {LocalMapId{1}};
  island.agents = {"alpha"};
  island.parts = {{LocalMapId{2}, "alpha"}};
  island.points.push_back({MapPointId{{2}, 5}, Eigen::Vector3d::Zero(), 7});
  const auto messages = ToProto(changes);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_THAT(messages[0].local_maps(), ElementsAre(1u, 2u));
  EXPECT_THAT(messages[0].local_map_agents(), ElementsAre("alpha", "alpha"));
  EXPECT_THAT(messages[0].islands(0).point_observations(), ElementsAre(7u));
}

TEST(MapChangesToProtoTest, NoMessageNamesMoreThanItsReadersTake) {
  MapChanges changes;
  for (uint64_t i = 1; i <= 2 * kMaxLocalMapsOfMessage; ++i) changes.removed_islands.push_back({i});
  int removed = 0;
  for (const auto& message : ToProto(changes)) {
    EXPECT_LE(message.local_maps_size(), kMaxLocalMapsOfMessage);
    removed += message.removed_island_slots_size();
  }
  EXPECT_EQ(removed, 2 * kMaxLocalMapsOfMessage);
}

// Of a mission in which many local maps were deleted, and which is full again: who comes back to it
// is told of both, and none of it is left out.
TEST(MapChangesToProtoTest, NamesOfTheDeletedDoNotCrowdOutThoseOfTheLiving) {
  constexpr uint64_t kDeleted = 4000;
  constexpr uint64_t kLiving = 7000;
  MapChanges changes;
  for (uint64_t i = 1; i <= kDeleted; ++i) changes.removed_islands.push_back({i});
  MapChanges::Island& island = changes.islands.emplace_back();
  island.id = {kDeleted + 1};
  for (uint64_t i = 1; i <= kLiving; ++i) {
    const LocalMapId living{kDeleted + i};
    island.local_maps.push_back(living);
    island.agents.push_back("alpha");
    island.removed_keyframes.push_back(KeyframeId{living, 3});
  }
  size_t removed = 0;
  std::set<LocalMapId> living;
  size_t keyframes = 0;
  for (const auto& message : ToProto(changes)) {
    const auto slots = SlotReader::Create(message.local_maps());
    ASSERT_TRUE(slots.ok()) << slots.status();
    removed += static_cast<size_t>(message.removed_island_slots_size());
    for (const auto& written : message.islands()) {
      for (const uint32_t slot : written.local_map_slots()) living.insert(*slots->LocalMap(slot));
      keyframes += static_cast<size_t>(written.removed_keyframes_size());
    }
  }
  EXPECT_EQ(removed, kDeleted);
  EXPECT_EQ(living.size(), kLiving);
  EXPECT_EQ(keyframes, kLiving);
}

}  // namespace
}  // namespace corbslam::services

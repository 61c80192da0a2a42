#include "services/map_store_service/map_changes_to_proto.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  island.points.emplace_back(MapPointId{{2}, 5}, Eigen::Vector3d::Zero());
  const auto messages = ToProto(changes);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_THAT(messages[0].local_maps(), ElementsAre(1u, 2u));
  EXPECT_THAT(messages[0].local_map_agents(), ElementsAre("alpha", "alpha"));
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

}  // namespace
}  // namespace corbslam::services

#include "services/client/store/local_map_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::Pair;
using ::testing::UnorderedElementsAre;

v1::LocalMap MapOf(const std::string& agent, const std::string& name, uint32_t number) {
  v1::LocalMap local_map;
  local_map.set_name(name);
  local_map.set_agent("missions/m/agents/" + agent);
  local_map.set_number(number);
  return local_map;
}

// alpha/1 is deleted, and alpha/3 has become a part of alpha/2.
TEST(LocalMapNamesTest, ALocalMapKeepsItsNumberWhateverBecomesOfOthers) {
  std::vector<v1::LocalMap> local_maps = {MapOf("alpha", "b", 2), MapOf("bravo", "x", 1),
                                          MapOf("alpha", "d", 4)};
  local_maps[0].add_joined_local_maps("c");
  local_maps[0].add_joined_numbers(3);
  EXPECT_THAT(ShortNames(local_maps),
              UnorderedElementsAre(Pair("b", "alpha/2"), Pair("c", "alpha/3"), Pair("d", "alpha/4"),
                                   Pair("x", "bravo/1")));
}

TEST(LocalMapNamesTest, LocalMapsOfAnOlderStoreAreCounted) {
  std::vector<v1::LocalMap> local_maps = {MapOf("alpha", "a", 0), MapOf("bravo", "x", 0),
                                          MapOf("alpha", "c", 0)};
  local_maps[0].add_joined_local_maps("b");
  EXPECT_THAT(ShortNames(local_maps),
              UnorderedElementsAre(Pair("a", "alpha/1"), Pair("b", "alpha/1"), Pair("c", "alpha/2"),
                                   Pair("x", "bravo/1")));
}

TEST(LocalMapNamesTest, NumbersThatFollowEachOtherAreSaidByTheirEnds) {
  EXPECT_EQ(DescribeNumbers("alpha", {1, 2, 3, 7, 9, 10}),
            "alpha/1 to alpha/3, alpha/7, alpha/9 to alpha/10");
  EXPECT_EQ(DescribeNumbers("alpha", {}), "");
}

}  // namespace
}  // namespace corbslam::services

#include "client_agent/tracking/point_set.h"

#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

TEST(PointSetTest, EachPointIsNewOnce) {
  PointSet points(LocalMapId{7});
  for (const LocalMapId map : {LocalMapId{7}, LocalMapId{8}, LocalMapId{9}}) {
    for (const uint32_t index : {5U, 0U, 70000U, 4U, 4294967294U}) {
      // The own map has no such numbers, and a bit for each of them would be a lot of memory.
      if (map.value == 7 && index > 70000U) continue;
      EXPECT_TRUE(points.Insert({map, index})) << map.value << ":" << index;
      EXPECT_FALSE(points.Insert({map, index})) << map.value << ":" << index;
    }
  }
}

}  // namespace
}  // namespace corbslam::client_agent

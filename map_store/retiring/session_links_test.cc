#include "map_store/retiring/session_links.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

constexpr KeyframeId kA1{{1}, 1}, kA2{{1}, 2}, kB1{{2}, 1}, kB2{{2}, 2}, kC1{{3}, 1};

TEST(SessionLinksTest, TheLastOverlapThatJoinsTwoIsNeeded) {
  SessionLinks links({{kA1, kB1}, {kA2, kB2}});
  EXPECT_TRUE(links.Holds(kA1));
  EXPECT_FALSE(links.Holds(kC1));
  EXPECT_FALSE(links.IsNeeded(kA1));
  EXPECT_FALSE(links.IsNeeded(kC1)) << "it holds none";
  links.Cut(kA1);
  EXPECT_FALSE(links.Holds(kA1));
  EXPECT_FALSE(links.Holds(kB1)) << "its overlap went with the other end";
  EXPECT_TRUE(links.IsNeeded(kA2));
  EXPECT_TRUE(links.IsNeeded(kB2));
}

TEST(SessionLinksTest, ARoundaboutWayIsEnough) {
  SessionLinks links({{kA1, kB1}, {kB2, kC1}, {kC1, kA2}});
  EXPECT_FALSE(links.IsNeeded(kA1));
  EXPECT_TRUE(links.IsNeeded(kC1)) << "both its overlaps would go";
  links.Cut(kA1);
  EXPECT_TRUE(links.IsNeeded(kB2));
}

// What is apart already does not hold anything.
TEST(SessionLinksTest, ThereMayBeNoOverlaps) {
  SessionLinks links({});
  EXPECT_FALSE(links.Holds(kA1));
  EXPECT_FALSE(links.IsNeeded(kA1));
  links.Cut(kA1);
}

}  // namespace
}  // namespace corbslam::map_store

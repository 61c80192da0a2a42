#include "services/tool/mission/event_text.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

const LocalMapNames& Names() {
  static const auto& names = *new LocalMapNames{{"missions/m/localMaps/0a", "alpha/1"},
                                                {"missions/m/localMaps/0b", "bravo/1"}};
  return names;
}

TEST(EventTextTest, NamesRobotsAndLocalMaps) {
  v1::MissionEvent event;
  event.mutable_agent_joined()->set_agent("missions/m/agents/alpha");
  EXPECT_EQ(DescribeEvent(event, Names()), "alpha joined");
  EXPECT_FALSE(IsWarning(event));
  auto* merged = event.mutable_islands_merged();
  merged->add_local_maps("missions/m/localMaps/0a");
  merged->add_local_maps("missions/m/localMaps/0b");
  merged->set_ms(340.2);
  EXPECT_EQ(DescribeEvent(event, Names()), "alpha/1 and bravo/1 are one island (340 ms)");
  auto* contradicted = event.mutable_map_contradicted();
  contradicted->set_agent("missions/m/agents/bravo");
  contradicted->set_owner("missions/m/agents/alpha");
  contradicted->set_local_map("missions/m/localMaps/0a");
  contradicted->mutable_found()->set_scale(1.02);
  EXPECT_EQ(DescribeEvent(event, Names()),
            "bravo goes without alpha/1, which is 2.00 % larger than what its camera measures "
            "(+-0.00 %)");
  EXPECT_TRUE(IsWarning(event));
  auto* lost = event.mutable_tracking_lost();
  lost->set_agent("missions/m/agents/bravo");
  lost->set_frames(1);
  EXPECT_EQ(DescribeEvent(event, Names()), "bravo did not know where it was, for 1 frame");
  EXPECT_TRUE(IsWarning(event));
}

TEST(EventTextTest, ALoopIsByOverlapsOrByItsOwner) {
  v1::MissionEvent event;
  event.mutable_loop_closed()->add_local_maps("missions/m/localMaps/0c");
  EXPECT_EQ(DescribeEvent(event, Names()), "the owner of 0c closed a loop");
  event.mutable_loop_closed()->set_overlaps(2);
  EXPECT_EQ(DescribeEvent(event, Names()), "a loop was closed in 0c by 2 overlaps");
}

TEST(EventTextTest, SaysSoWhereAnEventIsNew) {
  EXPECT_EQ(DescribeEvent(v1::MissionEvent(), Names()),
            "something that this program does not know");
}

}  // namespace
}  // namespace corbslam::services

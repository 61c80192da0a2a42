#include "map_store/mission/event_lines.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kOne = {1};
constexpr LocalMapId kTwo = {2};

TEST(EventLinesTest, SayWhoAndWhat) {
  EXPECT_EQ(LineOf("lab", MissionEvent::LocalMapBegun{kOne, "alpha"}),
            "mission=lab agent=alpha local map " + ToString(kOne) + " begins");
  EXPECT_EQ(
      LineOf("lab", MissionEvent::TrackingLost{kOne, "alpha", 3}),
      "mission=lab agent=alpha lost: 3 frames of local map " + ToString(kOne) + " without a pose");
  EXPECT_EQ(
      LineOf("lab", MissionEvent::TrackingLost{kTwo, "bravo", 1}),
      "mission=lab agent=bravo lost: 1 frame of local map " + ToString(kTwo) + " without a pose");
  EXPECT_EQ(LineOf("lab", MissionEvent::MapContradicted{"bravo", "alpha", {kOne, 0.986, 0.0016}}),
            "mission=lab agent=bravo goes without local map " + ToString(kOne) +
                " of alpha, which is 1.40 % smaller than what its camera measures (+-0.16 %)");
  EXPECT_EQ(LineOf("lab", MissionEvent::IslandsMerged{{kOne, kTwo}, {"alpha", "bravo"}, 340.4}),
            "mission=lab merged: the maps of alpha, bravo are in one frame (" + ToString(kOne) +
                ", " + ToString(kTwo) + "), after 340 ms");
}

TEST(EventLinesTest, WhatHappensAllTheTimeHasNone) {
  EXPECT_EQ(LineOf("lab", MissionEvent::OverlapAccepted{7, kOne, kTwo}), std::nullopt);
  EXPECT_EQ(LineOf("lab", MissionEvent::AgentJoined{"alpha"}), std::nullopt);
  EXPECT_EQ(LineOf("lab", MissionEvent::MapAdjusted{}), std::nullopt);
}

}  // namespace
}  // namespace corbslam::map_store

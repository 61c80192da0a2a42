#include "services/tool/evaluation/held_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using client_agent::NearMap;

constexpr LocalMapId kAlphas{1};
constexpr LocalMapId kBravos{2};
constexpr LocalMapId kStrangers{3};

Rigid3d At(double x) {
  Rigid3d pose;
  pose.translation = {x, 0, 0};
  return pose;
}

// Alpha drives from x = 0 to 60 m; bravo's keyframes, which it holds, reach from 40 to 100 m.
NearMap MakeHeld() {
  NearMap held;
  held.local_map = kAlphas;
  for (uint32_t i = 0; i <= 6; ++i) {
    held.keyframes.push_back({{kAlphas, i}, At(10.0 * i), false});
    held.keyframes.push_back({{kBravos, i}, At(40 + 10.0 * i), true});
  }
  held.own_points = {{0, 1, 0}, {61, 1, 0}};
  held.shared_points = {{62, 1, 0}, {100, 1, 0}};
  return held;
}

// The store knows whose local map is whose, and that each keyframe is the parent of the next.
ServedMap MakeServed() {
  ServedMap map;
  for (uint32_t i = 0; i <= 6; ++i) {
    for (const auto& [id, agent] : {std::pair(kAlphas, "alpha"), {kBravos, "bravo"}}) {
      const KeyframeId parent = i == 0 ? KeyframeId() : KeyframeId{id, i - 1};
      map.keyframes.push_back({{id, i}, parent, agent, At(1000)});
    }
  }
  return map;
}

TEST(ComposeHeldPictureTest, ShowsWhatCameToTheRobotInItsOwnFrame) {
  const MapPicture picture = ComposeHeldPicture("alpha", MakeHeld(), MakeServed());
  ASSERT_EQ(picture.robots.size(), 2u);
  EXPECT_EQ(picture.robots[0].name, "alpha");
  EXPECT_TRUE(picture.robots[0].is_own);
  EXPECT_EQ(picture.robots[1].name, "bravo");
  EXPECT_FALSE(picture.robots[1].is_own);
  EXPECT_EQ(picture.robots[1].keyframes.size(), 7u);
  EXPECT_EQ(picture.robots[1].keyframes.back().translation, Eigen::Vector3d(100, 0, 0))
      << "not where the store has it";
  EXPECT_EQ(picture.robots[0].edges.size(), 6u);
  EXPECT_EQ(picture.points.size(), 4u);
  EXPECT_NE(picture.title.find("alpha"), std::string::npos);
}

TEST(ComposeHeldPictureTest, LeavesOutWhatTheStoreAloneHas) {
  NearMap held = MakeHeld();
  std::erase_if(held.keyframes, [](const auto& keyframe) { return keyframe.shared; });
  const MapPicture picture = ComposeHeldPicture("alpha", held, MakeServed());
  ASSERT_EQ(picture.robots.size(), 1u);
  EXPECT_EQ(picture.robots[0].name, "alpha");
}

TEST(ComposeHeldPictureTest, TakesStrangersAndItsOwnEarlierMaps) {
  NearMap held = MakeHeld();
  held.keyframes.push_back({{kStrangers, 0}, At(5), true});
  // It began again: its first local map came back from the store.
  for (NearMap::NearKeyframe& keyframe : held.keyframes) {
    if (keyframe.id.local_map == kAlphas) keyframe.shared = true;
  }
  const MapPicture picture = ComposeHeldPicture("alpha", held, MakeServed());
  ASSERT_EQ(picture.robots.size(), 3u);
  EXPECT_EQ(picture.robots[0].name, "alpha");
  EXPECT_TRUE(picture.robots[0].is_own);
  EXPECT_EQ(picture.robots[1].name, "another robot");
  EXPECT_EQ(picture.robots[1].keyframes.size(), 1u);
}

TEST(CutMeetingTest, ShowsWhereTheOwnRobotDrivesAmongOthers) {
  const MapPicture held = ComposeHeldPicture("alpha", MakeHeld(), MakeServed());
  const std::optional<MapPicture> cut = CutMeeting(held);
  ASSERT_TRUE(cut.has_value());
  // Others are on both sides of 60 m. The box is 100 m long, so that 14.3 m around it are shown.
  ASSERT_EQ(cut->robots.size(), 2u);
  EXPECT_EQ(cut->robots[0].keyframes.size(), 2u);
  EXPECT_EQ(cut->robots[0].edges, (std::vector<std::pair<size_t, size_t>>{{0, 1}}));
  EXPECT_EQ(cut->robots[1].keyframes.size(), 3u);
  EXPECT_EQ(cut->robots[1].edges.size(), 2u);
  EXPECT_THAT(cut->points,
              ::testing::ElementsAre(Eigen::Vector3d(61, 1, 0), Eigen::Vector3d(62, 1, 0)));
}

TEST(CutMeetingTest, ThereIsNoneWherePointsLieFarFromAllCameras) {
  NearMap held = MakeHeld();
  held.own_points = {{60, 1, 30}};
  held.shared_points = {{62, 1, 30}};
  EXPECT_FALSE(CutMeeting(ComposeHeldPicture("alpha", held, MakeServed())).has_value());
}

TEST(CutMeetingTest, ThereIsNoneWithoutOthers) {
  NearMap held = MakeHeld();
  std::erase_if(held.keyframes, [](const auto& keyframe) { return keyframe.shared; });
  EXPECT_FALSE(CutMeeting(ComposeHeldPicture("alpha", held, MakeServed())).has_value());
  EXPECT_FALSE(CutMeeting({}).has_value());
}

}  // namespace
}  // namespace corbslam::services

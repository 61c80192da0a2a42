#include "services/tool/evaluation/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(ChooseOwnTest, IsTheFirstUnlessSomebodyIsNamed) {
  EXPECT_EQ(*ChooseOwn("", {"alpha", "bravo"}), "alpha");
  EXPECT_EQ(*ChooseOwn("bravo", {"alpha", "bravo"}), "bravo");
}

TEST(ChooseOwnTest, RefusesNobodyAndNamesTheRobots) {
  const absl::Status status = ChooseOwn("zulu", {"alpha", "bravo"}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("zulu"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("alpha, bravo"));
  EXPECT_EQ(ChooseOwn("", {}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(ComposePictureTest, MarksTheOwnRobot) {
  ServedMap map;
  map.keyframes = {{{LocalMapId{1}, 0}, {}, "bravo", {}}, {{LocalMapId{2}, 0}, {}, "alpha", {}}};
  const MapPicture picture = ComposePicture(map, "bravo", {});
  ASSERT_EQ(picture.robots.size(), 2u);
  EXPECT_FALSE(picture.robots[0].is_own);
  EXPECT_EQ(picture.robots[1].name, "bravo");
  EXPECT_TRUE(picture.robots[1].is_own);
}

// Of a drive with a keyframe a metre, what is left of a session that the store has thinned.
ServedMap Thinned() {
  ServedMap map;
  KeyframeId before;
  for (const uint32_t index : {0u, 1u, 2u, 3u, 60u}) {
    Rigid3d pose;
    pose.translation = {1.0 * index, 0, 0};
    map.keyframes.push_back({{LocalMapId{1}, index}, before, "alpha", pose});
    before = {LocalMapId{1}, index};
  }
  return map;
}

TEST(ComposePictureTest, JoinsNothingOverGapsOfAThinnedSession) {
  const MapPicture picture = ComposePicture(Thinned(), "alpha", {});
  ASSERT_EQ(picture.robots.size(), 1u);
  EXPECT_EQ(picture.robots[0].edges.size(), 3u);
  EXPECT_TRUE(picture.robots[0].paths.empty());
}

TEST(ComposePictureTest, DrawsPathsAsDriven) {
  RobotPaths robot;
  robot.name = "alpha";
  for (int i = 0; i <= 60; ++i) {
    Rigid3d pose;
    pose.translation = {1.0 * i, i < 30 ? 1.0 * i : 60.0 - i, 0};
    robot.global.push_back({int64_t{100} * i, pose, "1", "1", i == 40});
  }
  RobotPaths localiser = robot;
  localiser.name = "lima";
  const MapPicture picture = ComposePicture(Thinned(), "alpha", {}, DrivenOf({robot, localiser}));
  ASSERT_EQ(picture.robots.size(), 2u);
  EXPECT_TRUE(picture.robots[0].edges.empty());
  ASSERT_EQ(picture.robots[0].paths.size(), 2u);
  EXPECT_EQ(picture.robots[0].paths[0].size(), 40u);
  EXPECT_EQ(picture.robots[1].name, "lima") << "who only localised drove, too";
  EXPECT_TRUE(picture.robots[1].keyframes.empty());
}

}  // namespace
}  // namespace corbslam::services

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

}  // namespace
}  // namespace corbslam::services

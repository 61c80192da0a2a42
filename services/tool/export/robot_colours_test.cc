// Tests that a robot has one colour wherever it is shown.
#include "services/tool/export/robot_colours.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "slam/rendering/paint.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(RobotColoursTest, AreApartAndTheSameEveryTime) {
  const std::set<std::string> robots = {"a", "b", "c", "d", "e", "f", "g", "h"};
  const auto colours = ChooseColours(robots);
  EXPECT_EQ(colours, ChooseColours(robots));
  for (const auto& [name, colour] : colours) {
    for (const auto& [other_name, other] : colours) {
      const int apart = std::abs(colour.red - other.red) + std::abs(colour.green - other.green) +
                        std::abs(colour.blue - other.blue);
      EXPECT_TRUE(name == other_name || apart > 60) << name << " " << other_name;
    }
  }
  EXPECT_EQ(ToString(Colour{31, 119, 180}), "#1f77b4");
}

// The same numbers as in the page's robot_numbers_test.ts.
TEST(NumberRobotsTest, IsThePagesNumbering) {
  auto numbers = NumberRobots({"robot2", "robot10", "robot3"});
  EXPECT_EQ(numbers["robot2"], 2u);
  EXPECT_EQ(numbers["robot3"], 3u);
  EXPECT_EQ(numbers["robot10"], 4u);
  numbers = NumberRobots({"alpha", "bravo", "charlie", "Alpha-2", ""});
  EXPECT_EQ(numbers["alpha"], 0u);
  EXPECT_EQ(numbers["bravo"], 1u);
  EXPECT_EQ(numbers[""], 7u);
  // Names that ask for the same number: the first by its bytes has it.
  const auto in_order = [](const std::string& first, const std::string& second) {
    auto of_two = NumberRobots({first, second});
    return std::pair(of_two[first], of_two[second]);
  };
  EXPECT_EQ(in_order("robot-1", "robot_1"), std::pair(size_t{1}, size_t{2}));
  EXPECT_EQ(in_order("Bravo", "bot"), std::pair(size_t{1}, size_t{2}));
  EXPECT_EQ(in_order("r2", "r10"), std::pair(size_t{2}, size_t{3}));
  EXPECT_EQ(in_order("r3x", "r11x"), std::pair(size_t{3}, size_t{4}));
  EXPECT_EQ(in_order("r2", "r02"), std::pair(size_t{2}, size_t{3}));
  EXPECT_EQ(in_order("z1", "é1"), std::pair(size_t{1}, size_t{2}));
  EXPECT_EQ(in_order("Ａ1", "😀1"), std::pair(size_t{1}, size_t{2}));
  EXPECT_EQ(NumberRobots({"Ünal"})["Ünal"], 2u);
  std::set<std::string> many;
  for (int i = 0; i < 20; ++i) many.insert(absl::StrCat("x", i));
  std::set<std::string> colours;
  for (const auto& [name, colour] : ChooseColours(many)) colours.insert(ToString(colour));
  EXPECT_EQ(colours.size(), many.size());
}

std::string ReadPalette() {
  std::ifstream in(CORBSLAM_PAGE_PALETTE);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string Light(const Paint& paint) { return ToString({paint.red, paint.green, paint.blue}); }

std::string Dark(const NamedPaint& paint) { return absl::StrFormat("#%06x", paint.on_dark); }

TEST(PaintTest, IsThePagesPalette) {
  const std::string palette = ReadPalette();
  std::vector<std::string> light;
  std::vector<std::string> dark;
  for (size_t i = 0; i < 8; ++i) {
    light.push_back(Light(SeriesPaint(i)));
    dark.push_back(Dark(SeriesPaint(i)));
  }
  EXPECT_THAT(palette, HasSubstr(absl::StrCat("LIGHT = ['", absl::StrJoin(light, "', '"), "'];")));
  EXPECT_THAT(palette, HasSubstr(absl::StrCat("DARK = ['", absl::StrJoin(dark, "', '"), "'];")));
  const size_t light_begin = palette.find("  light: {\n");
  const size_t dark_begin = palette.find("  dark: {\n");
  ASSERT_LT(light_begin, dark_begin);
  ASSERT_NE(dark_begin, std::string::npos);
  const std::string light_scene = palette.substr(light_begin, dark_begin - light_begin);
  const std::string dark_scene = palette.substr(dark_begin);
  for (const auto& [name, paint] :
       {std::pair("own", kOwn), {"others", kOthers}, {"truth", kTruth}}) {
    EXPECT_THAT(light_scene, HasSubstr(absl::StrCat(" ", name, ": '", Light(paint), "'")));
    EXPECT_THAT(dark_scene, HasSubstr(absl::StrCat(" ", name, ": '", Dark(paint), "'")));
  }
  // What further robots are mixed with.
  EXPECT_THAT(palette, HasSubstr("{ light: '#000000', dark: '#303840' }"));
}

}  // namespace
}  // namespace corbslam::services

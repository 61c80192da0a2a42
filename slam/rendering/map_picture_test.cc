#include "slam/rendering/map_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_replace.h"
#include "slam/rendering/canvas.h"
#include "slam/rendering/view_from_above.h"

namespace corbslam {
namespace {

// The street goes 60 m along z and then turns; y is down.
MapPicture MakeStreet() {
  MapPicture picture;
  picture.title = "test street";
  picture.robots.resize(2);
  picture.robots[0].name = "alpha";
  picture.robots[0].is_own = true;
  picture.robots[1].name = "bravo";
  std::vector<Eigen::Vector3d> truth;
  for (int i = 0; i < 40; ++i) {
    Rigid3d pose;
    pose.translation = {0.02 * i * i, 0, 1.5 * i};
    MapPicture::Robot& robot = picture.robots[i < 22 ? 0 : 1];
    if (!robot.keyframes.empty()) {
      robot.edges.push_back({robot.keyframes.size() - 1, robot.keyframes.size()});
    }
    robot.keyframes.push_back(pose);
    truth.push_back(pose.translation + Eigen::Vector3d(0.3, 0, 0));
    for (const double side : {-8.0, 8.0}) {
      for (int k = 0; k < 10; ++k) {
        picture.points.push_back(pose.translation +
                                 Eigen::Vector3d(side + 0.3 * std::sin(k + i), -0.4 * k, 0.1 * k));
      }
    }
  }
  picture.points.push_back({1e5, 0, 0});  // An outlier must not shrink the rest.
  picture.truth.push_back(truth);
  return picture;
}

// Counts the pixels near a colour (blue, green, red).
int CountNear(const cv::Mat& image, const cv::Vec3b& colour) {
  int count = 0;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (cv::norm(image.at<cv::Vec3b>(y, x), colour) < 20) ++count;
    }
  }
  return count;
}

TEST(RenderMapTest, ShowsEverything) {
  const absl::StatusOr<cv::Mat> image = RenderMap(MakeStreet());
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_EQ(image->cols, 1200);
  EXPECT_GT(CountNear(*image, {47, 143, 10}), 300);  // Own keyframes are there.
  EXPECT_GT(CountNear(*image, {216, 79, 31}), 300);  // Others' keyframes are there.
  EXPECT_GT(CountNear(*image, {40, 40, 198}), 300);  // The truth is there.
  EXPECT_GT(CountNear(*image, {30, 30, 30}), 1000);  // Points and letters are there.
  EXPECT_GT(CountNear(*image, {255, 255, 255}), image->rows * image->cols / 2);
  const std::string path = ::testing::TempDir() + "map_picture_test.png";
  ASSERT_TRUE(WriteImage(*image, path).ok());
  EXPECT_EQ(cv::imread(path).size(), image->size());
}

TEST(RenderMapSvgTest, ShowsTheSame) {
  MapPicture picture = MakeStreet();
  picture.robots[1].name = "<bravo>";
  const absl::StatusOr<std::string> svg = RenderMapSvg(picture, SvgStyle::kAlone);
  ASSERT_TRUE(svg.ok()) << svg.status();
  EXPECT_THAT(*svg, ::testing::HasSubstr("test street"));
  EXPECT_THAT(*svg, ::testing::HasSubstr("others&#39; keyframes: &lt;bravo&gt; (18)"));
  EXPECT_THAT(*svg, ::testing::HasSubstr("stroke-dasharray"));
  EXPECT_THAT(*svg, ::testing::HasSubstr(" m</text>"));
  EXPECT_FALSE(RenderMapSvg({}, SvgStyle::kAlone).ok());
}

// Returns the texts of a drawing and how far right each one ends, as wide as Surface takes them.
std::vector<std::pair<std::string, double>> TextEnds(const std::string& svg, double letter_px) {
  std::vector<std::pair<std::string, double>> ends;
  const SvgSurface measure(1, 1, SvgStyle::kAlone);
  for (size_t at = svg.find("<text x=\""); at != std::string::npos;
       at = svg.find("<text x=\"", at + 1)) {
    const size_t begin = svg.find('>', at) + 1;
    const std::string text =
        absl::StrReplaceAll(svg.substr(begin, svg.find('<', begin) - begin), {{"&#39;", "'"}});
    ends.emplace_back(text, std::stod(svg.substr(at + 9)) + measure.TextWidth(text, letter_px));
  }
  return ends;
}

TEST(RenderMapSvgTest, CutsNoTextOff) {
  MapPicture picture = MakeStreet();
  picture.title = "Global map of 12 robots: fused ATE 0.123 m";
  picture.note = "not drawn, since nothing connects it with this map: zulu (12 keyframes)";
  for (int i = 0; i < 12; ++i) {
    picture.robots.push_back(picture.robots[1]);
    picture.robots.back().name = "a_robot_of_a_long_name_" + std::to_string(i);
  }
  for (const int width_px : {200, 400, 900, 1200}) {
    const auto svg = RenderMapSvg(picture, SvgStyle::kAlone, {width_px});
    ASSERT_TRUE(svg.ok()) << svg.status();
    const double letter_px = std::clamp(width_px / 50.0, 8.0, 14.0);
    for (const auto& [text, end_px] : TextEnds(*svg, letter_px)) {
      EXPECT_LE(end_px, width_px + 8) << width_px << ": " << text;
    }
  }
  const auto svg = RenderMapSvg(picture, SvgStyle::kAlone);
  EXPECT_THAT(*svg, ::testing::HasSubstr("\xE2\x80\xA6 (234)"));  // What it counts is not cut off.
  EXPECT_THAT(*svg, ::testing::HasSubstr("zulu (12 keyframes)"));
}

TEST(CanvasTest, ShowsAnEllipsisAsDots) {
  const Canvas canvas(1, 1);
  EXPECT_EQ(canvas.TextWidth("alpha\xE2\x80\xA6", 14), canvas.TextWidth("alpha...", 14));
}

TEST(RenderMapSvgTest, SaysHowManyOfThePointsItShows) {
  MapPicture picture = MakeStreet();
  picture.points.resize(10);
  EXPECT_THAT(*RenderMapSvg(picture, SvgStyle::kAlone), ::testing::HasSubstr("map points (10)"));
  picture.points.push_back({1e5, 0, 1e5});
  EXPECT_THAT(*RenderMapSvg(picture, SvgStyle::kAlone),
              ::testing::HasSubstr("map points (10 of 11)"));
  picture.all_points = 12'345;
  EXPECT_THAT(*RenderMapSvg(picture, SvgStyle::kAlone),
              ::testing::HasSubstr("map points (10 of 12345)"));
}

TEST(RenderMapTest, RefusesAnEmptyMap) {
  EXPECT_EQ(RenderMap({}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(RenderMapTest, DrawsASingleKeyframe) {
  MapPicture picture;
  picture.robots.resize(1);
  picture.robots[0].keyframes.resize(1);
  EXPECT_TRUE(RenderMap(picture).ok());
}

TEST(WriteImageTest, NamesAFolderThatIsNotThere) {
  EXPECT_EQ(WriteImage(cv::Mat::zeros(4, 4, CV_8UC3), "/nowhere/map.png").code(),
            absl::StatusCode::kUnavailable);
}

TEST(WriteImageTest, WritesTheKindThatTheNameSays) {
  const std::string stem = ::testing::TempDir() + "write_image_test";
  const cv::Mat image = cv::Mat::zeros(4, 4, CV_8UC3);
  ASSERT_TRUE(WriteImage(image, stem + ".PNG").ok());
  EXPECT_EQ(cv::imread(stem + ".PNG").size(), image.size());
  for (const char* end : {".pdf", "", "."}) {
    const absl::Status status = WriteImage(image, stem + end);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << end;
    EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr(stem + end));
  }
}

TEST(LookFromAboveTest, ShowsTheGroundAndTheMotionAcross) {
  std::vector<Rigid3d> poses(10);
  for (size_t i = 0; i < poses.size(); ++i) {
    poses[i].translation = {0, 0.1 * std::sin(i), static_cast<double>(i)};
  }
  const PlaneFromWorld plane_from_world = LookFromAbove(poses);
  // The motion (z) goes to the right; the camera's left side (-x) lies above in the picture.
  EXPECT_NEAR((plane_from_world * Eigen::Vector3d::UnitZ()).x(), 1, 1e-6);
  EXPECT_NEAR((plane_from_world * Eigen::Vector3d::UnitX()).y(), 1, 1e-6);
  EXPECT_NEAR((plane_from_world * Eigen::Vector3d::UnitY()).norm(), 0, 1e-6);
}

TEST(ChooseBoundsTest, ShowsTheRoomThatACameraOnADeskLooksInto) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 100; ++i) points.push_back({1.5 + 0.01 * i, 0.02 * i});
  const Bounds room = ChooseBounds({{0, 0}, {0.4, 0.1}}, points);
  EXPECT_GT(room.high.x(), 2.35);  // 1.4 times the path's extent end at 0.96.
  // A few points far away change nothing.
  points = {{0.1, 0.1}, {0.2, 0}, {0.3, 0.1}};
  points.resize(60, {0.2, 0.1});
  for (int i = 0; i < 5; ++i) points.push_back({100, 100});
  EXPECT_LT(ChooseBounds({{0, 0}, {0.4, 0.1}}, points).high.x(), 1.1);
}

TEST(RoundLengthTest, IsOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(RoundLength(47), 20);
  EXPECT_DOUBLE_EQ(RoundLength(50), 50);
  EXPECT_DOUBLE_EQ(RoundLength(0.19), 0.1);
  EXPECT_DOUBLE_EQ(RoundLength(1), 1);
}

}  // namespace
}  // namespace corbslam

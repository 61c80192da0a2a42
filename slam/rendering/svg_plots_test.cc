#include "slam/rendering/svg_plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// No drawing has numbers that are none.
MATCHER(IsDrawing, "") {
  return arg.starts_with("<svg ") && arg.ends_with("</svg>\n") &&
         arg.find("nan") == std::string::npos && arg.find("inf") == std::string::npos;
}

LinePlot MakePlot(std::vector<Eigen::Vector2d> points) {
  LinePlot plot;
  plot.title = "error";
  plot.x_label = "time (s)";
  plot.y_label = "error (m)";
  plot.series = {{"<alpha>", SeriesPaint(0), std::move(points), true}};
  return plot;
}

TEST(LinePlotTest, HasCurveLabelsAndLegend) {
  const std::string svg = DrawLinePlot(MakePlot({{0, 1}, {1, 3}, {2, 2}}), SvgStyle::kAlone);
  EXPECT_THAT(svg,
              AllOf(IsDrawing(), HasSubstr("time (s)"), HasSubstr("error (m)"),
                    HasSubstr("&lt;alpha&gt;"), HasSubstr("#0072b2"), Not(HasSubstr("<alpha>"))));
}

TEST(LinePlotTest, TakesAnyNumbers) {
  for (const std::vector<Eigen::Vector2d>& points : {std::vector<Eigen::Vector2d>{},
                                                     {{kNaN, kNaN}},
                                                     {{0, kInfinity}, {1, 1}},
                                                     {{3, 4}},
                                                     {{1e300, 1}, {-1e300, 2}},
                                                     {{0, 0}, {0, 0}},
                                                     {{0, 1e14}, {1, -1e14}}}) {
    EXPECT_THAT(DrawLinePlot(MakePlot(points), SvgStyle::kInAPage), IsDrawing());
  }
  EXPECT_THAT(DrawLinePlot(MakePlot({}), SvgStyle::kInAPage), HasSubstr("no values"));
  EXPECT_THAT(DrawLinePlot({}, SvgStyle::kInAPage), HasSubstr("no values"));
}

TEST(LinePlotTest, ManyNamesGetRows) {
  LinePlot plot;
  for (int i = 0; i < 40; ++i) {
    plot.series.push_back(
        {absl::StrCat("a robot with a long name, number ", i), SeriesPaint(0), {{0, 1}, {1, 2}}});
  }
  EXPECT_THAT(DrawLinePlot(plot, SvgStyle::kAlone), AllOf(IsDrawing(), HasSubstr("\xE2\x80\xA6")));
}

TEST(PathPlotTest, IsColouredByValue) {
  PathPlot plot;
  plot.value_label = "error (m)";
  plot.paths = {{{{0, 0}, {10, 0}, {20, 5}}, {0, 0.5, 1}}};
  plot.truth = {{{0, 0}, {20, 4}}};
  const std::string svg = DrawPathPlot(plot, SvgStyle::kAlone);
  EXPECT_THAT(svg, AllOf(IsDrawing(), HasSubstr("error (m)"), HasSubstr("stroke-dasharray"),
                         HasSubstr(" m</text>"), HasSubstr("truth")));
}

TEST(PathPlotTest, TheColourBarEndsWithANumber) {
  PathPlot plot;
  plot.value_label = "error (m)";
  for (const auto& [largest, end] : {std::pair(0.0298, "0.03"), {1.02, "1.5"}, {7.0, "8"}}) {
    plot.paths = {{{{0, 0}, {10, 0}, {20, 5}}, {0, 0.5 * largest, largest}}};
    EXPECT_THAT(DrawPathPlot(plot, SvgStyle::kAlone),
                HasSubstr(absl::StrCat("text-anchor=\"middle\">", end, "</text>")));
  }
}

TEST(PathPlotTest, TakesAnyNumbers) {
  using Path = PathPlot::Path;
  for (const Path& path :
       {Path{}, Path{{{1, 1}}, {0.5}}, Path{{{kNaN, 1}}, {1}},
        Path{{{0, 0}, {1, 1}}, {kNaN, kInfinity}}, Path{{{0, 0}, {1e300, 1}}, {1, 2}},
        Path{{{0, 0}, {1, 1}, {2, 2}}, {1}}, Path{{{5, 5}, {5, 5}}, {0, 0}}}) {
    PathPlot plot;
    plot.paths = {path};
    EXPECT_THAT(DrawPathPlot(plot, SvgStyle::kAlone), IsDrawing());
  }
  EXPECT_THAT(DrawPathPlot({}, SvgStyle::kAlone), HasSubstr("no values"));
}

TEST(TimelineTest, HasALaneForEachRobot) {
  Timeline timeline;
  timeline.x_label = "time (s)";
  timeline.lanes = {{"alpha", SeriesPaint(0), {{0, 4}, {5, 9}}, {5}},
                    {"bravo", SeriesPaint(1), {}, {}}};
  EXPECT_THAT(DrawTimeline(timeline, SvgStyle::kAlone),
              AllOf(IsDrawing(), HasSubstr("alpha"), HasSubstr("bravo"), HasSubstr("time (s)")));
  timeline.lanes = {{"alpha", SeriesPaint(0), {{kNaN, 3}, {2, 2}}, {kInfinity}}};
  EXPECT_THAT(DrawTimeline(timeline, SvgStyle::kAlone), IsDrawing());
  EXPECT_THAT(DrawTimeline({}, SvgStyle::kAlone),
              AllOf(IsDrawing(), HasSubstr("nothing happened")));
}

TEST(BarPlotTest, SaysWhatItLeavesOut) {
  BarPlot plot;
  for (int i = 0; i < 50; ++i)
    plot.bars.push_back({"bar", SeriesPaint(0), 1.0 * i, absl::StrCat(i)});
  EXPECT_THAT(DrawBarPlot(plot, SvgStyle::kAlone), AllOf(IsDrawing(), HasSubstr("and 10 more")));
  plot.bars = {{"bar", SeriesPaint(0), kNaN, "-"}, {"bar", SeriesPaint(0), -3, "-3"}};
  EXPECT_THAT(DrawBarPlot(plot, SvgStyle::kAlone), IsDrawing());
  EXPECT_THAT(DrawBarPlot({}, SvgStyle::kAlone), AllOf(IsDrawing(), HasSubstr("no values")));
}

// One point between two gaps, as of a robot that was lost before and behind it.
TEST(LinePlotTest, ALonePointCanBeSeen) {
  LinePlot plot = MakePlot({{0, 1}, {kNaN, kNaN}, {1, 3}, {kNaN, kNaN}, {2, 2}, {3, 2}});
  plot.series[0].has_marks = false;
  const std::string svg = DrawLinePlot(plot, SvgStyle::kAlone);
  const size_t curve = svg.find("stroke=\"#0072b2\" stroke-width=\"1.8\"");
  ASSERT_NE(curve, std::string::npos);
  const std::string data = svg.substr(svg.rfind("<path d=", curve), 200);
  const std::string path = data.substr(0, data.find(" fill"));
  size_t dots = 0;
  for (size_t at = path.find("h0"); at != std::string::npos; at = path.find("h0", at + 1)) ++dots;
  EXPECT_EQ(dots, 2u) << path;
}

TEST(TimelineTest, AMomentCanBeSeen) {
  Timeline timeline;
  timeline.lanes = {{"alpha", SeriesPaint(0), {{0, 9}}, {}},
                    {"bravo", SeriesPaint(1), {{4, 4}}, {}}};
  const std::string svg = DrawTimeline(timeline, SvgStyle::kAlone);
  const size_t bar = svg.find("stroke=\"#c94f00\"");
  ASSERT_NE(bar, std::string::npos);
  const size_t begin = svg.rfind("<path d=\"M", bar) + 10;
  const size_t line = svg.find('L', begin);
  EXPECT_NEAR(std::stod(svg.substr(line + 1)) - std::stod(svg.substr(begin)), 2, 0.11);
}

TEST(RampPaintTest, GrowsLighterForThoseWhoSeeNoColours) {
  const auto light = [](const Paint& paint) {
    return 0.2126 * std::pow(paint.red / 255.0, 2.2) + 0.7152 * std::pow(paint.green / 255.0, 2.2) +
           0.0722 * std::pow(paint.blue / 255.0, 2.2);
  };
  for (double share = 0; share < 0.99; share += 0.25) {
    EXPECT_GT(light(RampPaint(share + 0.25)), 1.1 * light(RampPaint(share))) << share;
  }
}

TEST(RampPaintTest, GoesFromBlueToOrange) {
  EXPECT_GT(RampPaint(0).blue, RampPaint(0).red);
  EXPECT_GT(RampPaint(1).red, RampPaint(1).blue);
  EXPECT_EQ(RampPaint(7).red, RampPaint(1).red);
  EXPECT_EQ(RampPaint(kNaN).red, RampPaint(kNaN).blue);
}

}  // namespace
}  // namespace corbslam

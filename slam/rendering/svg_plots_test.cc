#include "slam/rendering/svg_plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

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
  const std::string svg = DrawLinePlot(MakePlot({{0, 1}, {1, 3}, {2, 2}}), SvgLook::kAlone);
  EXPECT_THAT(svg,
              AllOf(IsDrawing(), HasSubstr("time (s)"), HasSubstr("error (m)"),
                    HasSubstr("&lt;alpha&gt;"), HasSubstr("#1e8c32"), Not(HasSubstr("<alpha>"))));
}

TEST(LinePlotTest, TakesAnyNumbers) {
  for (const std::vector<Eigen::Vector2d>& points : {std::vector<Eigen::Vector2d>{},
                                                     {{kNaN, kNaN}},
                                                     {{0, kInfinity}, {1, 1}},
                                                     {{3, 4}},
                                                     {{1e300, 1}, {-1e300, 2}},
                                                     {{0, 0}, {0, 0}},
                                                     {{0, 1e14}, {1, -1e14}}}) {
    EXPECT_THAT(DrawLinePlot(MakePlot(points), SvgLook::kInAPage), IsDrawing());
  }
  EXPECT_THAT(DrawLinePlot(MakePlot({}), SvgLook::kInAPage), HasSubstr("no values"));
  EXPECT_THAT(DrawLinePlot({}, SvgLook::kInAPage), HasSubstr("no values"));
}

TEST(LinePlotTest, ManyNamesGetRows) {
  LinePlot plot;
  for (int i = 0; i < 40; ++i) {
    plot.series.push_back(
        {absl::StrCat("a robot with a long name, number ", i), SeriesPaint(0), {{0, 1}, {1, 2}}});
  }
  EXPECT_THAT(DrawLinePlot(plot, SvgLook::kAlone), AllOf(IsDrawing(), HasSubstr("\xE2\x80\xA6")));
}

TEST(PathPlotTest, IsColouredByValue) {
  PathPlot plot;
  plot.value_label = "error (m)";
  plot.paths = {{{{0, 0}, {10, 0}, {20, 5}}, {0, 0.5, 1}}};
  plot.truth = {{{0, 0}, {20, 4}}};
  const std::string svg = DrawPathPlot(plot, SvgLook::kAlone);
  EXPECT_THAT(svg, AllOf(IsDrawing(), HasSubstr("error (m)"), HasSubstr("stroke-dasharray"),
                         HasSubstr(" m</text>"), HasSubstr("truth")));
}

TEST(PathPlotTest, TakesAnyNumbers) {
  using Path = PathPlot::Path;
  for (const Path& path :
       {Path{}, Path{{{1, 1}}, {0.5}}, Path{{{kNaN, 1}}, {1}},
        Path{{{0, 0}, {1, 1}}, {kNaN, kInfinity}}, Path{{{0, 0}, {1e300, 1}}, {1, 2}},
        Path{{{0, 0}, {1, 1}, {2, 2}}, {1}}, Path{{{5, 5}, {5, 5}}, {0, 0}}}) {
    PathPlot plot;
    plot.paths = {path};
    EXPECT_THAT(DrawPathPlot(plot, SvgLook::kAlone), IsDrawing());
  }
  EXPECT_THAT(DrawPathPlot({}, SvgLook::kAlone), HasSubstr("no values"));
}

TEST(TimelineTest, HasALaneForEachRobot) {
  Timeline timeline;
  timeline.x_label = "time (s)";
  timeline.lanes = {{"alpha", SeriesPaint(0), {{0, 4}, {5, 9}}, {5}},
                    {"bravo", SeriesPaint(1), {}, {}}};
  EXPECT_THAT(DrawTimeline(timeline, SvgLook::kAlone),
              AllOf(IsDrawing(), HasSubstr("alpha"), HasSubstr("bravo"), HasSubstr("time (s)")));
  timeline.lanes = {{"alpha", SeriesPaint(0), {{kNaN, 3}, {2, 2}}, {kInfinity}}};
  EXPECT_THAT(DrawTimeline(timeline, SvgLook::kAlone), IsDrawing());
  EXPECT_THAT(DrawTimeline({}, SvgLook::kAlone), AllOf(IsDrawing(), HasSubstr("nothing happened")));
}

TEST(BarPlotTest, SaysWhatItLeavesOut) {
  BarPlot plot;
  for (int i = 0; i < 50; ++i)
    plot.bars.push_back({"bar", SeriesPaint(0), 1.0 * i, absl::StrCat(i)});
  EXPECT_THAT(DrawBarPlot(plot, SvgLook::kAlone), AllOf(IsDrawing(), HasSubstr("and 10 more")));
  plot.bars = {{"bar", SeriesPaint(0), kNaN, "-"}, {"bar", SeriesPaint(0), -3, "-3"}};
  EXPECT_THAT(DrawBarPlot(plot, SvgLook::kAlone), IsDrawing());
  EXPECT_THAT(DrawBarPlot({}, SvgLook::kAlone), AllOf(IsDrawing(), HasSubstr("no values")));
}

TEST(RampPaintTest, GoesFromBlueToRed) {
  EXPECT_GT(RampPaint(0).blue, RampPaint(0).red);
  EXPECT_GT(RampPaint(1).red, RampPaint(1).blue);
  EXPECT_EQ(RampPaint(7).red, RampPaint(1).red);
  EXPECT_EQ(RampPaint(kNaN).red, RampPaint(kNaN).blue);
}

}  // namespace
}  // namespace corbslam

// Plots of a run's report, as SVG. Any numbers and any texts will do: what is not finite is left
// out, and a plot without values says that there are none.
#ifndef CORBSLAM_SLAM_RENDERING_SVG_PLOTS_H_
#define CORBSLAM_SLAM_RENDERING_SVG_PLOTS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slam/rendering/paint.h"
#include "slam/rendering/svg_surface.h"

namespace corbslam {

// Curves over one axis, from zero up.
struct LinePlot {
  struct Series {
    std::string name;
    Paint paint;
    std::vector<Eigen::Vector2d> points;  // In the order of x; a gap where one is not finite.
    bool has_marks = false;               // A disc at each point.
  };
  std::string title;
  std::string x_label;  // With its unit.
  std::string y_label;
  std::vector<Series> series;
};
std::string DrawLinePlot(const LinePlot& plot, SvgStyle style);

// Paths from above, coloured by a value, with equal axes, a colour bar and a scale bar; true paths
// are dashed.
struct PathPlot {
  struct Path {
    std::vector<Eigen::Vector2d> points;
    std::vector<double> values;  // One a point.
  };
  std::string title;
  std::string value_label;
  std::string unit = "m";  // Unit of the plane.
  std::vector<Path> paths;
  std::vector<std::vector<Eigen::Vector2d>> truth;
};
std::string DrawPathPlot(const PathPlot& plot, SvgStyle style);

// What happened when: a lane for each robot, with spans and marks.
struct Timeline {
  struct Span {
    double begin = 0;
    double end = 0;
  };
  struct Lane {
    std::string name;
    Paint paint;
    std::vector<Span> spans;
    std::vector<double> marks;  // Moments, as thin lines.
  };
  std::string title;
  std::string x_label;
  std::vector<Lane> lanes;
};
std::string DrawTimeline(const Timeline& timeline, SvgStyle style);

// Horizontal bars, one below the other.
struct BarPlot {
  struct Bar {
    std::string name;
    Paint paint;
    double value = 0;
    std::string text;  // The value as it stands behind the bar.
  };
  std::string title;
  std::string x_label;
  std::vector<Bar> bars;  // Of more than 40 the last are left out, and counted.
};
std::string DrawBarPlot(const BarPlot& plot, SvgStyle style);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_SVG_PLOTS_H_

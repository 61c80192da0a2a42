// What the plots share: their size, their legend, and how long curves are thinned.
#ifndef CORBSLAM_SLAM_RENDERING_PLOT_PARTS_H_
#define CORBSLAM_SLAM_RENDERING_PLOT_PARTS_H_

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "slam/rendering/surface.h"

namespace corbslam {

// Narrow, so that letters can be read where a phone shows the plot in its width.
inline constexpr double kPlotWidth_px = 480;
inline constexpr double kPlotLeft_px = 58;
inline constexpr double kPlotRight_px = 18;
inline constexpr double kPlotBottom_px = 44;
inline constexpr size_t kMostNameLetters = 24;

using LegendEntries = std::vector<std::pair<std::string, Paint>>;

// Draws entries in rows from `top_px` on and returns where the rows end. Null: only measures.
double DrawEntries(const LegendEntries& entries, double top_px, const Surface& measure,
                   Surface* surface);

// Says in the middle that there is nothing to see.
void DrawNothing(double height_px, const std::string& why, Surface& surface);

// Keeps the first, the lowest, the highest and the last point of each of `columns` columns, in
// their order, and one point that is not finite wherever there is a gap. Peaks stay.
std::vector<Eigen::Vector2d> ThinCurve(const std::vector<Eigen::Vector2d>& points, size_t columns);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_PLOT_PARTS_H_

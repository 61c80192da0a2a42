// Says in a picture of a map what is what.
#ifndef CORBSLAM_SLAM_RENDERING_MAP_LEGEND_H_
#define CORBSLAM_SLAM_RENDERING_MAP_LEGEND_H_

#include <string>

#include "slam/rendering/map_picture.h"
#include "slam/rendering/surface.h"

namespace corbslam {

inline constexpr double kMapMargin_px = 36;
inline constexpr double kMapHeader_px = 84;

// Draws title and legend into the picture's head, which is kMapHeader_px high.
void DrawLegend(const MapPicture& picture, Surface& surface);

// Returns the names of own or of others' robots, with the number of their keyframes: "alpha (12)".
std::string JoinNames(const MapPicture& picture, bool own);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_MAP_LEGEND_H_

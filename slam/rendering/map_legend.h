// Says in a picture of a map what is what.
#ifndef CORBSLAM_SLAM_RENDERING_MAP_LEGEND_H_
#define CORBSLAM_SLAM_RENDERING_MAP_LEGEND_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slam/rendering/map_picture.h"
#include "slam/rendering/surface.h"

namespace corbslam {

inline constexpr double kMapMargin_px = 36;

// Title and entries above a map, and the note below it, in lines that fit.
struct MapLegend {
  enum class Sign { kOwn, kOthers, kPoint, kTruth };
  struct Entry {
    Sign sign = Sign::kOwn;
    std::string label;
    Eigen::Vector2d at_px = Eigen::Vector2d::Zero();  // The middle of the sign's left side.
  };
  std::string title;
  std::vector<Entry> entries;
  std::vector<std::string> note;
  double letter_px = 0;
  double header_px = 0;  // Height of title and entries.
  double note_px = 0;    // Height of the note.
};

// Lays out what is said of a picture that is `width_px` wide and shows `points` of the map's
// points. What has no room in a line of its own is shortened, and ends with an ellipsis and what it
// counts.
MapLegend ArrangeLegend(const MapPicture& picture, size_t points, double width_px,
                        const Surface& measure);

// Draws title and entries at the top, and the note so that it ends at `bottom_px`.
void DrawLegend(const MapLegend& legend, double bottom_px, Surface& surface);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_MAP_LEGEND_H_

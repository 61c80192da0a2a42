// Draws a map from above into a rectangle of a picture. All pictures of maps are made of such
// cells.
#ifndef CORBSLAM_SLAM_RENDERING_MAP_CELL_H_
#define CORBSLAM_SLAM_RENDERING_MAP_CELL_H_

#include <vector>

#include "slam/rendering/map_picture.h"
#include "slam/rendering/surface.h"
#include "slam/rendering/view_from_above.h"

namespace corbslam {

// From where a map is looked at, and what of it is shown. It may show other states of the same map,
// too.
struct MapView {
  PlaneFromWorld plane_from_world = PlaneFromWorld::Zero();
  Bounds bounds;
};

// `picture` must have a keyframe.
MapView ChooseView(const MapPicture& picture);

// Where the plane of the map lies in the picture.
struct CellLayout {
  Bounds bounds;  // All that is seen, in the plane.
  double px_per_unit = 1;
  Eigen::Vector2d origin_px = Eigen::Vector2d::Zero();  // Where bounds.low lies.

  Eigen::Vector2d Place(const Eigen::Vector2d& x) const {
    return (x - bounds.low) * px_per_unit + origin_px;
  }
};

// Fits the view into a rectangle, centred.
CellLayout FitCell(const Bounds& bounds, const Bounds& rectangle_px);

// Returns how many points the bounds hold.
size_t CountSeen(const std::vector<Eigen::Vector3d>& points, const PlaneFromWorld& plane_from_world,
                 const Bounds& bounds);

// Draws points, then others' keyframes, then own ones, then the truth. What lies outside is left
// out.
void DrawMap(const MapPicture& picture, const PlaneFromWorld& plane_from_world,
             const CellLayout& layout, Surface& surface);

// Draws a bar of a round length, about a quarter of the layout's width, from `at_px` to the right.
void DrawScaleBar(const std::string& unit, const CellLayout& layout, const Eigen::Vector2d& at_px,
                  double letter_px, Surface& surface);

// Returns the shape of a keyframe: a wedge that opens to where the camera looks.
std::vector<Eigen::Vector2d> KeyframeShape(const Eigen::Vector2d& centre,
                                           const Eigen::Vector2d& view_direction);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_MAP_CELL_H_

// A map seen from above, drawn like the figures of the CORB-SLAM paper: own keyframes green,
// others' blue, map points black, the true path dashed; with legend and scale bar.
#ifndef CORBSLAM_SLAM_RENDERING_MAP_PICTURE_H_
#define CORBSLAM_SLAM_RENDERING_MAP_PICTURE_H_

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/geometry/rigid3.h"
#include "slam/rendering/svg_surface.h"

namespace corbslam {

// Everything is in one frame, which may be any.
struct MapPicture {
  struct Robot {
    std::string name;
    bool is_own = false;
    std::vector<Rigid3d> keyframes;  // Poses world_from_camera.
    // Pairs of entries of `keyframes` (spanning tree, loops).
    std::vector<std::pair<size_t, size_t>> edges;
    // Where it drove, piece by piece; drawn like edges.
    std::vector<std::vector<Eigen::Vector3d>> paths = {};
  };
  std::string title;
  std::vector<Robot> robots;
  std::vector<Eigen::Vector3d> points;
  size_t all_points = 0;  // How many the map has, where `points` are only some of them.
  std::vector<std::vector<Eigen::Vector3d>> truth;  // True paths.
  std::string unit = "m";                           // Unit of the scale bar.
  std::string note;  // What a reader must know of what isn't drawn; below the map.
};

struct MapPictureOptions {
  int width_px = 1200;
};

// Draws in 8-bit BGR on white, `width_px` wide, with a height that follows from the map's shape.
// "Above" is against the mean direction of the cameras' y axes, or where these cancel out the
// direction of least motion; the longest motion lies across the picture. INVALID_ARGUMENT without
// any keyframe or for a width that is not 200 to 10,000.
absl::StatusOr<cv::Mat> RenderMap(const MapPicture& picture, const MapPictureOptions& options = {});

// Draws the same as SVG.
absl::StatusOr<std::string> RenderMapSvg(const MapPicture& picture, SvgStyle style,
                                         const MapPictureOptions& options = {});

// Writes a picture of the kind that the path's ending names, .png say. INVALID_ARGUMENT names an
// ending that no kind has; other errors are WriteAtomically's.
absl::Status WriteImage(const cv::Mat& image, const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_MAP_PICTURE_H_

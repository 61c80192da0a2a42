// What pictures are drawn on: pixels (canvas.h) or vectors (svg_surface.h).
#ifndef CORBSLAM_SLAM_RENDERING_SURFACE_H_
#define CORBSLAM_SLAM_RENDERING_SURFACE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slam/rendering/paint.h"

namespace corbslam {

enum class Anchor { kStart, kMiddle, kEnd };

// Coordinates are pixels of the final picture, x to the right, y downwards. Not thread-safe.
class Surface {
 public:
  using Point = Eigen::Vector2d;

  virtual ~Surface() = default;
  virtual double width_px() const = 0;

  virtual void Line(const Point& from, const Point& to, const Paint& paint, double width_px) = 0;
  // A path with a gap where a point is not finite.
  virtual void Path(const std::vector<Point>& path, const Paint& paint, double width_px) = 0;
  virtual void DashedPath(const std::vector<Point>& path, const Paint& paint, double width_px,
                          double dash_px, double gap_px) = 0;
  virtual void Discs(const std::vector<Point>& centres, double radius_px, const Paint& paint) = 0;
  // `corners` are those of a convex polygon.
  virtual void FilledPolygon(const std::vector<Point>& corners, const Paint& paint,
                             const Paint& outline) = 0;
  // `at` is on the letters' base line: the left end of the text, its middle or its right end.
  // `height_px` is that of a capital letter.
  virtual void Text(const std::string& text, const Point& at, double height_px, const Paint& paint,
                    Anchor anchor = Anchor::kStart) = 0;
  // Returns how wide a text is, at least about.
  virtual double TextWidth(const std::string& text, double height_px) const = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_SURFACE_H_

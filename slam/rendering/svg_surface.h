// Writes drawings as SVG.
#ifndef CORBSLAM_SLAM_RENDERING_SVG_SURFACE_H_
#define CORBSLAM_SLAM_RENDERING_SVG_SURFACE_H_

#include <string>
#include <vector>

#include "slam/rendering/surface.h"

namespace corbslam {

enum class SvgStyle {
  kAlone,    // A file of its own: colours as they are, on white.
  kInAPage,  // Part of an HTML page, which sets the colours as CSS variables; no ground.
};

// Everything is written as presentation attributes: a page needs no style for it, and may forbid
// styles that stand at elements. What is not finite is left out.
class SvgSurface : public Surface {
 public:
  SvgSurface(double width_px, double height_px, SvgStyle style);
  double width_px() const override { return width_px_; }

  void Line(const Point& from, const Point& to, const Paint& paint, double width_px) override;
  void Path(const std::vector<Point>& path, const Paint& paint, double width_px) override;
  void DashedPath(const std::vector<Point>& path, const Paint& paint, double width_px,
                  double dash_px, double gap_px) override;
  void Discs(const std::vector<Point>& centres, double radius_px, const Paint& paint) override;
  void FilledPolygon(const std::vector<Point>& corners, const Paint& paint,
                     const Paint& outline) override;
  void Text(const std::string& text, const Point& at, double height_px, const Paint& paint,
            Anchor anchor = Anchor::kStart) override;
  double TextWidth(const std::string& text, double height_px) const override;

  // Returns the whole drawing. `title` says what it is to those who don't see it.
  std::string Finish(const std::string& title) const;

 private:
  std::string Colour(const Paint& paint) const;
  // Writes a path of lines with these further attributes.
  void Stroke(const std::vector<Point>& path, const Paint& paint, double width_px,
              const std::string& attributes);

  const double width_px_;
  const double height_px_;
  const SvgStyle style_;
  std::string body_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_SVG_SURFACE_H_

// Drawing with sub-pixel accuracy on a white picture.
#ifndef CORBSLAM_SLAM_RENDERING_CANVAS_H_
#define CORBSLAM_SLAM_RENDERING_CANVAS_H_

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "slam/rendering/surface.h"

namespace corbslam {

// The canvas is drawn at twice the size and averaged down in the end, which smooths edges and
// letters. Methods may throw cv::Exception, as OpenCV does.
class Canvas : public Surface {
 public:
  Canvas(int width_px, int height_px);
  double width_px() const override;

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

  // Returns 8-bit BGR.
  cv::Mat Finish() const;

 private:
  cv::Mat image_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_CANVAS_H_

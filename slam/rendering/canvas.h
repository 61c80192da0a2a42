// Drawing with sub-pixel accuracy on a white picture, in coordinates of the final picture.
#ifndef CORBSLAM_SLAM_RENDERING_CANVAS_H_
#define CORBSLAM_SLAM_RENDERING_CANVAS_H_

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace corbslam {

using Colour = cv::Scalar;  // Blue, green, red.

// Not thread-safe. The canvas is drawn at twice the size and averaged down in the end, which
// smooths edges and letters. Methods may throw cv::Exception, as OpenCV does.
class Canvas {
 public:
  Canvas(int width_px, int height_px);
  int width_px() const;

  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Colour& colour,
            double width_px);
  void DashedPath(const std::vector<Eigen::Vector2d>& path, const Colour& colour, double width_px,
                  double dash_px, double gap_px);
  void Disc(const Eigen::Vector2d& centre, double radius_px, const Colour& colour);
  void FilledPolygon(const std::vector<Eigen::Vector2d>& corners, const Colour& colour,
                     const Colour& outline);
  // `left_baseline` is the lower left corner of the first letter.
  void Text(const std::string& text, const Eigen::Vector2d& left_baseline, double height_px,
            const Colour& colour);
  static double TextWidth(const std::string& text, double height_px);

  cv::Mat Finish() const;

 private:
  cv::Mat image_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_CANVAS_H_

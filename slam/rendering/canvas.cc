#include "slam/rendering/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace corbslam {
namespace {

constexpr int kOversampling = 2;
// OpenCV's fixed-point coordinates: sixteenths of a pixel.
constexpr int kShift = 4;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

cv::Point ToFixed(const Eigen::Vector2d& x) {
  const double factor = kOversampling * (1 << kShift);
  return {static_cast<int>(std::lround(x.x() * factor)),
          static_cast<int>(std::lround(x.y() * factor))};
}

int ToThickness(double width_px) {
  return std::max(1, static_cast<int>(std::lround(width_px * kOversampling)));
}

double FontScale(double height_px) {
  return cv::getFontScaleFromHeight(kFont, 100) * height_px / 100;
}

}  // namespace

Canvas::Canvas(int width_px, int height_px)
    : image_(height_px * kOversampling, width_px * kOversampling, CV_8UC3,
             cv::Scalar(255, 255, 255)) {}

int Canvas::width_px() const { return image_.cols / kOversampling; }

void Canvas::Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Colour& colour,
                  double width_px) {
  cv::line(image_, ToFixed(from), ToFixed(to), colour, ToThickness(width_px), cv::LINE_AA, kShift);
}

void Canvas::DashedPath(const std::vector<Eigen::Vector2d>& path, const Colour& colour,
                        double width_px, double dash_px, double gap_px) {
  double travelled_px = 0;  // Way within the current dash and its gap.
  for (size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector2d step = path[i] - path[i - 1];
    const double length_px = step.norm();
    for (double at_px = 0; at_px < length_px;) {
      const bool is_dash = travelled_px < dash_px;
      const double rest_px = (is_dash ? dash_px : dash_px + gap_px) - travelled_px;
      const double advance_px = std::min(rest_px, length_px - at_px);
      if (is_dash) {
        Line(path[i - 1] + step * (at_px / length_px),
             path[i - 1] + step * ((at_px + advance_px) / length_px), colour, width_px);
      }
      at_px += advance_px;
      travelled_px = advance_px < rest_px ? travelled_px + advance_px : (is_dash ? dash_px : 0);
    }
  }
}

void Canvas::Disc(const Eigen::Vector2d& centre, double radius_px, const Colour& colour) {
  const auto radius = static_cast<int>(std::lround(radius_px * kOversampling * (1 << kShift)));
  cv::circle(image_, ToFixed(centre), radius, colour, cv::FILLED, cv::LINE_AA, kShift);
}

void Canvas::FilledPolygon(const std::vector<Eigen::Vector2d>& corners, const Colour& colour,
                           const Colour& outline) {
  std::vector<cv::Point> fixed;
  for (const Eigen::Vector2d& corner : corners) fixed.push_back(ToFixed(corner));
  cv::fillConvexPoly(image_, fixed, colour, cv::LINE_AA, kShift);
  cv::polylines(image_, fixed, true, outline, 1, cv::LINE_AA, kShift);
}

void Canvas::Text(const std::string& text, const Eigen::Vector2d& left_baseline, double height_px,
                  const Colour& colour) {
  const cv::Point origin(static_cast<int>(std::lround(left_baseline.x() * kOversampling)),
                         static_cast<int>(std::lround(left_baseline.y() * kOversampling)));
  cv::putText(image_, text, origin, kFont, FontScale(height_px * kOversampling), colour, 2,
              cv::LINE_AA);
}

double Canvas::TextWidth(const std::string& text, double height_px) {
  int baseline = 0;
  return static_cast<double>(
             cv::getTextSize(text, kFont, FontScale(height_px * kOversampling), 2, &baseline)
                 .width) /
         kOversampling;
}

cv::Mat Canvas::Finish() const {
  cv::Mat image;
  cv::resize(image_, image, {}, 1.0 / kOversampling, 1.0 / kOversampling, cv::INTER_AREA);
  return image;
}

}  // namespace corbslam

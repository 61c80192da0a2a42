#include "slam/rendering/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_replace.h"

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

cv::Scalar ToScalar(const Paint& paint) {
  return {static_cast<double>(paint.blue), static_cast<double>(paint.green),
          static_cast<double>(paint.red)};
}

double FontScale(double height_px) {
  return cv::getFontScaleFromHeight(kFont, 100) * height_px / 100;
}

// The font has ASCII only, and shows each byte of an ellipsis as a question mark.
std::string ToAscii(const std::string& text) {
  return absl::StrReplaceAll(text, {{"\xE2\x80\xA6", "..."}});
}

}  // namespace

Canvas::Canvas(int width_px, int height_px)
    : image_(height_px * kOversampling, width_px * kOversampling, CV_8UC3,
             cv::Scalar(255, 255, 255)) {}

double Canvas::width_px() const { return image_.cols / kOversampling; }

void Canvas::Line(const Point& from, const Point& to, const Paint& paint, double width_px) {
  cv::line(image_, ToFixed(from), ToFixed(to), ToScalar(paint), ToThickness(width_px), cv::LINE_AA,
           kShift);
}

void Canvas::Path(const std::vector<Point>& path, const Paint& paint, double width_px) {
  for (size_t i = 1; i < path.size(); ++i) {
    if (path[i - 1].allFinite() && path[i].allFinite()) Line(path[i - 1], path[i], paint, width_px);
  }
}

void Canvas::DashedPath(const std::vector<Point>& path, const Paint& paint, double width_px,
                        double dash_px, double gap_px) {
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
             path[i - 1] + step * ((at_px + advance_px) / length_px), paint, width_px);
      }
      at_px += advance_px;
      travelled_px = advance_px < rest_px ? travelled_px + advance_px : (is_dash ? dash_px : 0);
    }
  }
}

void Canvas::Discs(const std::vector<Point>& centres, double radius_px, const Paint& paint) {
  const auto radius = static_cast<int>(std::lround(radius_px * kOversampling * (1 << kShift)));
  for (const Point& centre : centres) {
    cv::circle(image_, ToFixed(centre), radius, ToScalar(paint), cv::FILLED, cv::LINE_AA, kShift);
  }
}

void Canvas::FilledPolygon(const std::vector<Point>& corners, const Paint& paint,
                           const Paint& outline) {
  std::vector<cv::Point> fixed;
  for (const Point& corner : corners) fixed.push_back(ToFixed(corner));
  cv::fillConvexPoly(image_, fixed, ToScalar(paint), cv::LINE_AA, kShift);
  cv::polylines(image_, fixed, true, ToScalar(outline), 1, cv::LINE_AA, kShift);
}

void Canvas::Text(const std::string& text, const Point& at, double height_px, const Paint& paint,
                  Anchor anchor) {
  double left_px = at.x();
  if (anchor != Anchor::kStart) {
    left_px -= TextWidth(text, height_px) * (anchor == Anchor::kMiddle ? 0.5 : 1.0);
  }
  const cv::Point origin(static_cast<int>(std::lround(left_px * kOversampling)),
                         static_cast<int>(std::lround(at.y() * kOversampling)));
  cv::putText(image_, ToAscii(text), origin, kFont, FontScale(height_px * kOversampling),
              ToScalar(paint), 2, cv::LINE_AA);
}

double Canvas::TextWidth(const std::string& text, double height_px) const {
  int baseline = 0;
  return static_cast<double>(cv::getTextSize(ToAscii(text), kFont,
                                             FontScale(height_px * kOversampling), 2, &baseline)
                                 .width) /
         kOversampling;
}

cv::Mat Canvas::Finish() const {
  cv::Mat image;
  cv::resize(image_, image, {}, 1.0 / kOversampling, 1.0 / kOversampling, cv::INTER_AREA);
  return image;
}

}  // namespace corbslam

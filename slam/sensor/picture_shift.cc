#include "slam/sensor/picture_shift.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>
#include <vector>

namespace corbslam {
namespace {

constexpr int kMostTurns = 15;
constexpr double kTurnedEnough_px = 0.05;
constexpr double kLeastAlike = 0.7;
// Of the smaller picture so much must be in the other one.
constexpr double kLeastCommon = 0.3;

// What a pixel of the picture before tells of the shift.
struct Pixel {
  Eigen::Vector2d from_middle;
  double grey = 0;
  Eigen::Vector3d slope;  // By x, y and turn.
};

Eigen::Vector2d MiddleOf(const cv::Mat& picture) {
  return {(picture.cols - 1) / 2.0, (picture.rows - 1) / 2.0};
}

std::vector<Pixel> PixelsOf(const cv::Mat& picture) {
  std::vector<Pixel> pixels;
  pixels.reserve(picture.total());
  const Eigen::Vector2d middle = MiddleOf(picture);
  for (int y = 1; y + 1 < picture.rows; ++y) {
    for (int x = 1; x + 1 < picture.cols; ++x) {
      const auto at = [&](int u, int v) { return static_cast<double>(picture.at<uint8_t>(v, u)); };
      Pixel pixel;
      pixel.from_middle = Eigen::Vector2d(x, y) - middle;
      pixel.grey = at(x, y);
      const double slope_x = (at(x + 1, y) - at(x - 1, y)) / 2;
      const double slope_y = (at(x, y + 1) - at(x, y - 1)) / 2;
      pixel.slope = {slope_x, slope_y,
                     slope_y * pixel.from_middle.x() - slope_x * pixel.from_middle.y()};
      pixels.push_back(pixel);
    }
  }
  return pixels;
}

std::optional<double> GreyAt(const cv::Mat& picture, const Eigen::Vector2d& at) {
  if (!(at.x() >= 0 && at.y() >= 0)) return std::nullopt;
  if (!(at.x() < picture.cols - 1 && at.y() < picture.rows - 1)) return std::nullopt;
  const int x = static_cast<int>(at.x());
  const int y = static_cast<int>(at.y());
  const double right = at.x() - x;
  const double lower = at.y() - y;
  const uint8_t* const above = picture.ptr<uint8_t>(y) + x;
  const uint8_t* const below = picture.ptr<uint8_t>(y + 1) + x;
  return (1 - lower) * ((1 - right) * above[0] + right * above[1]) +
         lower * ((1 - right) * below[0] + right * below[1]);
}

// The normal equations of shift, turn, contrast and brightness, and how alike the pictures are.
struct Equations {
  Eigen::Matrix<double, 5, 5> information = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> along = Eigen::Matrix<double, 5, 1>::Zero();
  double seen_squared = 0;
  size_t pixels = 0;

  // The correlation of the two pictures where both are.
  double Correlation() const {
    const auto n = static_cast<double>(pixels);
    const double before_variance = information(3, 3) - information(3, 4) * information(3, 4) / n;
    const double now_variance = seen_squared - along(4) * along(4) / n;
    const double common = along(3) - information(3, 4) * along(4) / n;
    return common / std::sqrt(std::max(1e-9, before_variance * now_variance));
  }
};

// `shift` is in pixels of these pictures.
Equations SumUp(const std::vector<Pixel>& pixels, const cv::Mat& now, const PictureShift& shift) {
  Equations equations;
  const Eigen::Vector2d middle = MiddleOf(now) + shift.shift_px;
  const double c = std::cos(shift.turn_rad);
  const double s = std::sin(shift.turn_rad);
  for (const Pixel& pixel : pixels) {
    const Eigen::Vector2d turned(c * pixel.from_middle.x() - s * pixel.from_middle.y(),
                                 s * pixel.from_middle.x() + c * pixel.from_middle.y());
    const std::optional<double> seen = GreyAt(now, middle + turned);
    if (!seen.has_value()) continue;
    Eigen::Matrix<double, 5, 1> row;
    row << pixel.slope, pixel.grey, 1;
    equations.information.selfadjointView<Eigen::Lower>().rankUpdate(row);
    equations.along += row * *seen;
    equations.seen_squared += *seen * *seen;
    ++equations.pixels;
  }
  equations.information.triangularView<Eigen::StrictlyUpper>() = equations.information.transpose();
  return equations;
}

// Moves `shift`, in pixels of these pictures, to where they look alike. Returns false where they
// don't.
bool Align(const cv::Mat& before, const cv::Mat& now, PictureShift& shift) {
  const std::vector<Pixel> pixels = PixelsOf(before);
  const auto least = static_cast<size_t>(kLeastCommon * static_cast<double>(pixels.size()));
  for (int i = 0; i < kMostTurns; ++i) {
    const Equations equations = SumUp(pixels, now, shift);
    if (equations.pixels < std::max<size_t>(least, 50)) return false;
    const Eigen::Matrix<double, 5, 1> step = equations.information.ldlt().solve(equations.along);
    const double contrast = step(3);
    if (!(contrast > 0.2)) return false;
    // What the picture before would have to be moved by, the other is moved back by.
    const Eigen::Vector3d moved = step.head<3>() / contrast;
    const double c = std::cos(shift.turn_rad);
    const double s = std::sin(shift.turn_rad);
    shift.shift_px -= Eigen::Vector2d(c * moved.x() - s * moved.y(), s * moved.x() + c * moved.y());
    shift.turn_rad -= moved.z();
    if (!shift.shift_px.allFinite() || std::abs(shift.turn_rad) > 1) return false;
    if (moved.head<2>().norm() < kTurnedEnough_px) break;
  }
  return SumUp(pixels, now, shift).Correlation() > kLeastAlike;
}

}  // namespace

std::optional<PictureShift> FindPictureShift(const HalvedPicture& before,
                                             const HalvedPicture& now) {
  constexpr size_t kSmallest = HalvedPicture::kLevels - 1;
  PictureShift shift;
  for (size_t level = kSmallest; level >= kSmallest - 1; --level) {
    if (before.levels[level].size() != now.levels[level].size()) return std::nullopt;
    if (!Align(before.levels[level], now.levels[level], shift)) return std::nullopt;
    if (level > kSmallest - 1) shift.shift_px *= 2;
  }
  shift.shift_px *= 1 << (kSmallest - 1);
  return shift;
}

}  // namespace corbslam

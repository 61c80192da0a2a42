#include "services/simulation/obstructions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace corbslam {
namespace {

// The hand's edge is soft over this share of the width, and its fingers reach out by as much.
constexpr double kSoft = 0.1;
constexpr double kFingers = 4;
constexpr double kHandLight = 0.1;
constexpr double kShading = 0.04;

}  // namespace

void Defocus(double deviation_px, cv::Mat& light) {
  if (deviation_px <= 0) return;
  cv::GaussianBlur(light, light, cv::Size(), deviation_px, deviation_px, cv::BORDER_REPLICATE);
}

void CoverByHand(double share, cv::Mat& light) {
  if (share <= 0) return;
  for (int y = 0; y < light.rows; ++y) {
    const double down = static_cast<double>(y) / light.rows;
    const double finger = std::sin(2 * std::numbers::pi * kFingers * down);
    const double edge = 1 - share * (1 + 2 * kSoft) + kSoft * (1 - finger) / 2;
    const double hand = kHandLight + kShading * finger;
    auto* row = light.ptr<float>(y);
    for (int x = 0; x < light.cols; ++x) {
      const double right = static_cast<double>(x) / light.cols;
      const double weight = std::clamp((right - edge) / kSoft, 0.0, 1.0);
      row[x] = static_cast<float>((1 - weight) * row[x] + weight * hand);
    }
  }
}

}  // namespace corbslam

#include "slam/sensor/row_offset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace corbslam {
namespace {

// A pair with fewer counterparts is dark or bare: it tells nothing.
constexpr size_t kLeastCounterparts = 100;
constexpr size_t kPairs = 10;
// A mean of pairs is beyond doubt when it is so many times its standard deviation.
constexpr double kCertain = 4;
// Aligned patches show this share of an offset: they believe in none, and tend to whole rows.
constexpr double kShown = 0.75;
// What a rig that was never moved is moved for, and one that was; shown by patches.
constexpr double kWorthIt_px = 0.12;
constexpr double kWorthMore_px = 0.02;
// A rig that is off by more is to be calibrated: its counterparts are not even sought.
constexpr double kMost_px = 2;

struct Mean {
  double value = 0;
  double sigma = 0;
};

Mean MeanOf(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += value;
  double squares = 0;
  for (const double value : values) squares += (value - sum / count) * (value - sum / count);
  return {sum / count, std::sqrt(squares / (count * (count - 1)))};
}

}  // namespace

void RowOffset::Add(const RowEvidence& evidence) {
  if (evidence.counterparts < kLeastCounterparts) return;
  medians_px_.push_back(evidence.median_px);
  if (medians_px_.size() < kPairs) return;
  const Mean mean = MeanOf(medians_px_);
  medians_px_.clear();
  const double worth_it_px = correction_px_ == 0 ? kWorthIt_px : kWorthMore_px;
  if (std::abs(mean.value) < std::max(worth_it_px, kCertain * mean.sigma)) return;
  correction_px_ = std::clamp(correction_px_ + mean.value / kShown, -kMost_px, kMost_px);
}

cv::Mat MoveUp(const cv::Mat& picture, double rows_px) {
  const double whole = std::floor(rows_px);
  const auto t = static_cast<float>(rows_px - whole);
  std::array<float, 4> weights = {((-t + 2) * t - 1) * t / 2, ((3 * t - 5) * t * t + 2) / 2,
                                  ((-3 * t + 4) * t + 1) * t / 2, (t - 1) * t * t / 2};
  const cv::Mat kernel(static_cast<int>(weights.size()), 1, CV_32F, weights.data());
  const int rows = static_cast<int>(whole);
  const int border = std::abs(rows) + 2;
  cv::Mat moved;
  cv::copyMakeBorder(picture, moved, border, border, 0, 0,
                     cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  cv::filter2D(moved, moved, CV_8U, kernel, cv::Point(0, 1));
  return moved.rowRange(border + rows, border + rows + picture.rows);
}

}  // namespace corbslam

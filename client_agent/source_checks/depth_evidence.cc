#include "client_agent/source_checks/depth_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace corbslam::client_agent {
namespace {

constexpr int kStep_px = 3;
constexpr double kSaturated = 65535;
// A pixel nearer than its neighbour by this share is an outline, not a slope.
constexpr float kEdgeStep = 1.1F;
constexpr int kEdgeReach_px = 3;
constexpr size_t kMinEdges = 200;

double ValueAt(const cv::Mat& depth, int x, int y) {
  if (depth.type() == CV_16UC1) return depth.at<uint16_t>(y, x);
  const auto metres = static_cast<double>(depth.at<float>(y, x));
  return std::isfinite(metres) && metres > 0 ? metres : 0;
}

double Rank(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
}

// The depths beside (x, y) are both there and one is much nearer.
bool IsStep(float here, float beyond) { return here > 0 && beyond > kEdgeStep * here; }

}  // namespace

DepthStatistics MeasureDepth(const cv::Mat& depth, double units_per_m) {
  DepthStatistics statistics;
  const double units = depth.type() == CV_16UC1 ? units_per_m : 1;
  std::vector<double> values;
  size_t pixels = 0;
  size_t saturated = 0;
  for (int y = kStep_px / 2; y < depth.rows; y += kStep_px) {
    for (int x = kStep_px / 2; x < depth.cols; x += kStep_px) {
      const double value = ValueAt(depth, x, y);
      ++pixels;
      if (depth.type() == CV_16UC1 && value == kSaturated) {
        ++saturated;
      } else if (value > 0) {
        values.push_back(value / units);
      }
    }
  }
  if (pixels == 0) return statistics;
  statistics.saturated_share = static_cast<double>(saturated) / static_cast<double>(pixels);
  statistics.valid_share = static_cast<double>(values.size()) / static_cast<double>(pixels);
  if (values.empty()) return statistics;
  std::sort(values.begin(), values.end());
  statistics.near_m = Rank(values, 0.05);
  statistics.median_m = Rank(values, 0.5);
  statistics.far_m = Rank(values, 0.95);
  statistics.is_constant = values.front() == values.back();
  return statistics;
}

std::vector<cv::Point> FindDepthEdges(const cv::Mat& depth) {
  cv::Mat metres;
  depth.convertTo(metres, CV_32F);
  if (depth.type() == CV_16UC1) metres.setTo(0, depth == kSaturated);
  std::vector<cv::Point> edges;
  for (int y = kEdgeReach_px; y < depth.rows - kEdgeReach_px; ++y) {
    const auto* row = metres.ptr<float>(y);
    const auto* above = metres.ptr<float>(y - kEdgeReach_px);
    const auto* below = metres.ptr<float>(y + kEdgeReach_px);
    for (int x = kEdgeReach_px; x < depth.cols - kEdgeReach_px; ++x) {
      const float here = row[x];
      if (IsStep(here, row[x - kEdgeReach_px]) || IsStep(here, row[x + kEdgeReach_px]) ||
          IsStep(here, above[x]) || IsStep(here, below[x])) {
        edges.emplace_back(x, y);
      }
    }
  }
  return edges;
}

cv::Mat MeasureGreyEdges(const cv::Mat& grey) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {5, 5}, 1.0);
  cv::Mat across;
  cv::Mat along;
  cv::Sobel(smooth, across, CV_16S, 1, 0);
  cv::Sobel(smooth, along, CV_16S, 0, 1);
  cv::Mat edges;
  cv::Mat other;
  cv::convertScaleAbs(across, edges, 0.5);
  cv::convertScaleAbs(along, other, 0.5);
  cv::max(edges, other, edges);
  return edges;
}

double EdgeAgreement(const std::vector<cv::Point>& depth_edges, const cv::Mat& grey_edges,
                     const cv::Point& shift) {
  const cv::Rect inside(0, 0, grey_edges.cols, grey_edges.rows);
  double sum = 0;
  size_t count = 0;
  for (const cv::Point& edge : depth_edges) {
    const cv::Point at = edge + shift;
    if (!inside.contains(at)) continue;
    sum += grey_edges.at<uint8_t>(at);
    ++count;
  }
  const double everywhere = cv::mean(grey_edges)[0];
  if (count < kMinEdges || everywhere <= 0) return 0;
  return sum / static_cast<double>(count) / everywhere;
}

}  // namespace corbslam::client_agent

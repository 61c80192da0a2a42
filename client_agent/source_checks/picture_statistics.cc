#include "client_agent/source_checks/picture_statistics.h"

#include <array>
#include <cstdint>
#include <cstring>

namespace corbslam::client_agent {
namespace {

using Histogram = std::array<uint32_t, 256>;

// The smallest grey level up to which more than `share` of the pixels lie.
int Rank(const Histogram& histogram, uint32_t pixels, double share) {
  double below = 0;
  for (size_t grey = 0; grey < histogram.size(); ++grey) {
    below += histogram[grey];
    if (below > share * pixels) return static_cast<int>(grey);
  }
  return 255;
}

}  // namespace

PictureStatistics MeasurePicture(const cv::Mat& grey) {
  Histogram histogram = {};
  uint32_t pixels = 0;
  for (int y = 0; y < grey.rows; y += 2) {
    const auto* row = grey.ptr<uint8_t>(y);
    for (int x = 0; x < grey.cols; x += 2, ++pixels) ++histogram[row[x]];
  }
  PictureStatistics statistics;
  statistics.least = Rank(histogram, pixels, 0);
  statistics.dark = Rank(histogram, pixels, 0.01);
  statistics.median = Rank(histogram, pixels, 0.5);
  statistics.bright = Rank(histogram, pixels, 0.99);
  statistics.most = 255;
  while (statistics.most > 0 && histogram[static_cast<size_t>(statistics.most)] == 0) {
    --statistics.most;
  }
  statistics.white_share = static_cast<double>(histogram[255]) / pixels;
  return statistics;
}

bool AreSame(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  const size_t bytes = static_cast<size_t>(a.cols) * a.elemSize();
  for (int y = 0; y < a.rows; ++y) {
    if (std::memcmp(a.ptr(y), b.ptr(y), bytes) != 0) return false;
  }
  return true;
}

}  // namespace corbslam::client_agent

#include "client_agent/source/pictures/grey_depth.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "absl/strings/str_format.h"

namespace corbslam::client_agent {
namespace {

constexpr int kBitsOfAPixel = 16;
constexpr int kBitsKept = 8;
// Share of pixels that are hot, or that a decoder has spoilt.
constexpr double kHotShare = 1e-5;

// Number of pixels by value.
using Histogram = std::vector<uint64_t>;

void Count(const cv::Mat& grey, Histogram& histogram) {
  for (int y = 0; y < grey.rows; ++y) {
    const auto* row = grey.ptr<uint16_t>(y);
    for (int x = 0; x < grey.cols; ++x) ++histogram[row[x]];
  }
}

// Returns the largest value but for the hot ones; 0 without pixels.
int BrightestValue(const Histogram& histogram) {
  uint64_t pixels = 0;
  for (const uint64_t count : histogram) pixels += count;
  const auto hot = static_cast<uint64_t>(kHotShare * static_cast<double>(pixels));
  uint64_t brighter = 0;
  for (size_t value = histogram.size() - 1; value > 0; --value) {
    brighter += histogram[value];
    if (brighter > hot) return static_cast<int>(value);
  }
  return 0;
}

int UsedBits(int brightest) {
  for (const int bits : {8, 10, 12, 14}) {
    if (brightest < (1 << bits)) return bits;
  }
  return kBitsOfAPixel;
}

SourceFinding TellBits(int used_bits, int brightest) {
  return {FindingLevel::kWarning, "grey-bits-assumed",
          absl::StrFormat("grey pictures have 16 bits a pixel, but the brightest value of the "
                          "sample is %d of 65535: taken as pictures of %d bits, grey levels are "
                          "divided by %d. If the camera uses all 16 bits and these pictures are "
                          "just dark, convert them to 8 bits yourself",
                          brightest, used_bits, 1 << (used_bits - kBitsKept))};
}

}  // namespace

GreyDepth DecideGreyDepth(absl::Span<const cv::Mat> sample) {
  GreyDepth decision;
  Histogram histogram(size_t{1} << kBitsOfAPixel, 0);
  for (const cv::Mat& grey : sample) {
    if (grey.type() == CV_16UC1) Count(grey, histogram);
  }
  const int brightest = BrightestValue(histogram);
  // All is black, or there is no picture of 16 bits: there is nothing to see.
  if (brightest == 0) return decision;
  decision.used_bits = UsedBits(brightest);
  if (decision.used_bits < kBitsOfAPixel) {
    decision.findings.push_back(TellBits(decision.used_bits, brightest));
  }
  return decision;
}

cv::Mat ScaleGreyTo8(const cv::Mat& grey, int used_bits) {
  if (grey.type() == CV_8UC1) return grey;
  const int shift = std::clamp(used_bits, kBitsKept, kBitsOfAPixel) - kBitsKept;
  cv::Mat scaled(grey.size(), CV_8UC1);
  for (int y = 0; y < grey.rows; ++y) {
    const auto* from = grey.ptr<uint16_t>(y);
    auto* to = scaled.ptr<uint8_t>(y);
    for (int x = 0; x < grey.cols; ++x) {
      to[x] = static_cast<uint8_t>(std::min(from[x] >> shift, 255));
    }
  }
  return scaled;
}

}  // namespace corbslam::client_agent

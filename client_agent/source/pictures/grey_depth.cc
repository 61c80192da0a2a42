#include "client_agent/source/pictures/grey_depth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "absl/strings/str_format.h"

namespace corbslam::client_agent {
namespace {

constexpr int kBitsOfAPixel = 16;
constexpr int kBitsKept = 8;
// Share of pixels that are hot, or that a decoder has spoilt.
constexpr double kHotShare = 1e-5;
// Share of pixels that lamps and the sky may have, above which nearly all of a dark picture lies.
constexpr double kBrightShare = 0.01;
// Grey levels, of 256, of all other pixels: below the first one detectors see little, and a gain
// takes them up to the second at most.
constexpr double kDarkLevel = 96;
constexpr double kBrightEnough = 250;

// Number of pixels by value.
using Histogram = std::vector<uint64_t>;

void Count(const cv::Mat& grey, Histogram& histogram) {
  for (int y = 0; y < grey.rows; ++y) {
    const auto* row = grey.ptr<uint16_t>(y);
    for (int x = 0; x < grey.cols; ++x) ++histogram[row[x]];
  }
}

// Returns the largest value but for a share of the pixels; 0 without pixels.
int BrightestValue(const Histogram& histogram, double share) {
  uint64_t pixels = 0;
  for (const uint64_t count : histogram) pixels += count;
  const auto hot = static_cast<uint64_t>(share * static_cast<double>(pixels));
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

// Steps, so that a little more or less light changes nothing.
double ChooseGain(int usual, int used_bits) {
  const double level = std::ldexp(usual, kBitsKept - used_bits);
  if (level >= kDarkLevel) return 1;
  double chosen = 1;
  for (const double gain : {1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0}) {
    if (level * gain <= kBrightEnough) chosen = gain;
  }
  return chosen;
}

SourceFinding TellGain(const GreyDepth& decision, int usual) {
  return {FindingLevel::kWarning, "grey-dark",
          absl::StrFormat("grey pictures have 16 bits a pixel, and 99 of 100 pixels of the sample "
                          "are at most %d of %d: grey levels are made %g times as bright, so that "
                          "what is above %d becomes white. Give the camera more light or exposure, "
                          "or convert the pictures to 8 bits yourself",
                          usual, 1 << decision.used_bits, decision.gain, decision.White())};
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
  const int brightest = BrightestValue(histogram, kHotShare);
  // All is black, or there is no picture of 16 bits: there is nothing to see.
  if (brightest == 0) return decision;
  decision.used_bits = UsedBits(brightest);
  if (decision.used_bits < kBitsOfAPixel) {
    decision.findings.push_back(TellBits(decision.used_bits, brightest));
  }
  const int usual = BrightestValue(histogram, kBrightShare);
  decision.gain = ChooseGain(usual, decision.used_bits);
  if (decision.gain > 1) decision.findings.push_back(TellGain(decision, usual));
  return decision;
}

cv::Mat ScaleGreyTo8(const cv::Mat& grey, int white) {
  if (grey.type() == CV_8UC1) return grey;
  const auto divisor = static_cast<uint32_t>(std::clamp(white, 1, 1 << kBitsOfAPixel));
  cv::Mat scaled(grey.size(), CV_8UC1);
  for (int y = 0; y < grey.rows; ++y) {
    const auto* from = grey.ptr<uint16_t>(y);
    auto* to = scaled.ptr<uint8_t>(y);
    for (int x = 0; x < grey.cols; ++x) {
      to[x] = static_cast<uint8_t>(std::min((uint32_t{from[x]} << kBitsKept) / divisor, 255u));
    }
  }
  return scaled;
}

}  // namespace corbslam::client_agent

#include "slam/features/steered_brief.h"

#include <cmath>
#include <cstring>
#include <numbers>

namespace corbslam {
namespace {

uint16_t TurnedPosition(int x, int y, double angle, int stride) {
  const double cosine = std::cos(angle);
  const double sine = std::sin(angle);
  const int turned_x = static_cast<int>(std::lround(cosine * x - sine * y));
  const int turned_y = static_cast<int>(std::lround(sine * x + cosine * y));
  return static_cast<uint16_t>((turned_y + kBriefRadius_px) * stride + turned_x + kBriefRadius_px);
}

}  // namespace

SteeredBrief::SteeredBrief(const BriefPattern& pattern) : pairs_of_angle_(kAngles) {
  for (size_t i = 0; i < pairs_of_angle_.size(); ++i) {
    const double angle = static_cast<double>(i) * 2 * std::numbers::pi / kAngles;
    for (size_t t = 0; t < pattern.size(); ++t) {
      const BriefTest& test = pattern[t];
      pairs_of_angle_[i][t] = {TurnedPosition(test.x1, test.y1, angle, kPatchStride),
                               TurnedPosition(test.x2, test.y2, angle, kPatchStride)};
    }
  }
}

Descriptor SteeredBrief::Describe(const cv::Mat& smoothed, int x_px, int y_px,
                                  float angle_rad) const {
  // A copy of fixed stride lets one table of positions serve images of every width.
  uint8_t patch[kPatchStride * kPatchStride];
  for (int i = 0; i <= 2 * kBriefRadius_px; ++i) {
    std::memcpy(patch + i * kPatchStride,
                smoothed.ptr<uint8_t>(y_px - kBriefRadius_px + i) + x_px - kBriefRadius_px,
                kPatchStride);
  }
  constexpr float kStepsPerRad = kAngles / (2 * std::numbers::pi_v<float>);
  const auto step = static_cast<unsigned>(std::lround(angle_rad * kStepsPerRad)) % kAngles;
  const auto& pairs = pairs_of_angle_[step];
  Descriptor descriptor;
  for (size_t w = 0; w < descriptor.words.size(); ++w) {
    uint64_t word = 0;
    for (size_t b = 0; b < 64; ++b) {
      const Pair pair = pairs[w * 64 + b];
      word |= static_cast<uint64_t>(patch[pair.first] < patch[pair.second]) << b;
    }
    descriptor.words[w] = word;
  }
  return descriptor;
}

}  // namespace corbslam

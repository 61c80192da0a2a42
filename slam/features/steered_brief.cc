#include "slam/features/steered_brief.h"

#include <bit>
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

// Packs eight bytes of 0 or 1 into bits, the first one lowest. The factor moves each byte to its
// place in the top byte, and no two to one place.
uint64_t EightBits(const uint8_t* bytes) {
  static_assert(std::endian::native == std::endian::little);
  uint64_t eight = 0;
  std::memcpy(&eight, bytes, sizeof(eight));
  return (eight * 0x0102040810204080) >> 56;
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
  std::array<uint8_t, kBriefTests> is_darker;
  for (size_t t = 0; t < kBriefTests; ++t) {
    is_darker[t] = patch[pairs[t].first] < patch[pairs[t].second];
  }
  Descriptor descriptor;
  for (size_t t = 0; t < kBriefTests; t += 8) {
    descriptor.words[t / 64] |= EightBits(&is_darker[t]) << (t % 64);
  }
  return descriptor;
}

}  // namespace corbslam

#include "services/simulation/lens.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "services/simulation/dice.h"
#include "services/simulation/parallel_rows.h"

namespace corbslam {
namespace {

// Returns 255 times the light, which is at most 2. The two products round as they do since the
// first pictures: one alone would now and then give another grey level.
float LevelOf(float light) {
  constexpr float kSteps = 2048;
  constexpr float kLevelsPerStep = 255 / kSteps;
  const float steps = std::clamp(light * kSteps, 0.0F, 2 * kSteps);
  const auto whole = static_cast<float>(static_cast<int>(steps));
  return whole * kLevelsPerStep + (steps - whole) * kLevelsPerStep;
}

uint64_t Mixed(uint64_t x) { return Dice(x).Next(); }

// Returns a nearly normal number with variance 1: the sum of the eight bytes of a hash.
float Noise(uint64_t key) {
  const uint64_t bits = Mixed(key);
  const uint64_t pairs = (bits & 0x00FF00FF00FF00FFU) + ((bits >> 8) & 0x00FF00FF00FF00FFU);
  const uint64_t sum = (pairs * 0x0001000100010001U) >> 48;
  constexpr float kMean = 8 * 127.5F;
  constexpr float kDeviation = 209.02F;  // It is sqrt(8 (256^2 - 1) / 12).
  return (static_cast<float>(sum) - kMean) / kDeviation;
}

// Returns 1 in the middle and 1 - vignetting in the corners; it falls with the square of the
// distance.
float Transmission(float x, float y, const cv::Size& size, float vignetting) {
  const float dx = 2 * x / static_cast<float>(size.width) - 1;
  const float dy = 2 * y / static_cast<float>(size.height) - 1;
  return 1 - vignetting * 0.5F * (dx * dx + dy * dy);
}

double ExposureAt(const Lens& lens, double time_s) {
  constexpr double kPeriod_s = 23;
  return lens.exposure *
         (1 + lens.exposure_drift * std::sin(2 * std::numbers::pi * time_s / kPeriod_s));
}

}  // namespace

cv::Mat Develop(const cv::Mat& light, const Lens& lens, double time_s, uint64_t stream,
                int threads) {
  cv::Mat blurred = light;
  if (lens.blur_px > 0) {
    cv::GaussianBlur(light, blurred, cv::Size(5, 5), lens.blur_px, lens.blur_px,
                     cv::BORDER_REPLICATE);
  }
  const auto exposure = static_cast<float>(ExposureAt(lens, time_s));
  const auto read = static_cast<float>(lens.read_noise * lens.read_noise);
  const auto shot = static_cast<float>(lens.shot_noise * lens.shot_noise / 255);
  const auto vignetting = static_cast<float>(lens.vignetting);
  const uint64_t key = Mixed(lens.noise_seed ^ Mixed(stream));
  cv::Mat grey(light.size(), CV_8UC1);
  ParallelRows(threads, light.rows, [&](int y) {
    const float* from = blurred.ptr<float>(y);
    uint8_t* to = grey.ptr<uint8_t>(y);
    const uint64_t row_key = key + static_cast<uint64_t>(y) * static_cast<uint64_t>(light.cols);
    for (int x = 0; x < light.cols; ++x) {
      const float passed =
          Transmission(static_cast<float>(x), static_cast<float>(y), light.size(), vignetting);
      const float level = LevelOf(from[x] * exposure * passed);
      const float noise = Noise(row_key + static_cast<uint64_t>(x));
      const float noisy = level + noise * std::sqrt(read + shot * level);
      to[x] = static_cast<uint8_t>(std::clamp(noisy + 0.5F, 0.0F, 255.0F));
    }
  });
  return grey;
}

}  // namespace corbslam

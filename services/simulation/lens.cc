#include "services/simulation/lens.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_format.h"
#include "services/simulation/dice.h"
#include "services/simulation/parallel_rows.h"

namespace corbslam {
namespace {

absl::Status Require(double value, double least, double most, const char* field) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s: %g, must be %g to %g", field, value, least, most));
}

// Computes 255 light^gamma by interpolation in a table.
class ToneCurve {
 public:
  explicit ToneCurve(double gamma) {
    for (size_t i = 0; i < table_.size(); ++i) {
      const double light = static_cast<double>(i) / kPerUnit;
      table_[i] = static_cast<float>(255 * std::pow(light, gamma));
    }
  }
  float operator()(float light) const {
    const float x = std::clamp(light * kPerUnit, 0.0F, kLast);
    const auto i = static_cast<size_t>(x);
    return table_[i] + (x - static_cast<float>(i)) * (table_[i + 1] - table_[i]);
  }

 private:
  static constexpr int kPerUnit = 2048;
  static constexpr float kLast = 2 * kPerUnit;
  std::array<float, 2 * kPerUnit + 2> table_;
};

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

absl::Status Validate(const Lens& lens) {
  for (const absl::Status& status :
       {Require(lens.exposure, 0.01, 100, "exposure"),
        Require(lens.exposure_drift, 0, 1, "exposure_drift"), Require(lens.gamma, 0.1, 10, "gamma"),
        Require(lens.vignetting, 0, 1, "vignetting"), Require(lens.blur_px, 0, 10, "blur_px"),
        Require(lens.read_noise, 0, 100, "read_noise"),
        Require(lens.shot_noise, 0, 100, "shot_noise"),
        Require(lens.motion_blur_samples, 1, 64, "motion_blur_samples")}) {
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

cv::Mat Develop(const cv::Mat& light, const Lens& lens, double time_s, uint64_t stream,
                int threads) {
  cv::Mat blurred = light;
  if (lens.blur_px > 0) {
    cv::GaussianBlur(light, blurred, cv::Size(5, 5), lens.blur_px, lens.blur_px,
                     cv::BORDER_REPLICATE);
  }
  const ToneCurve tone(lens.gamma);
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
      const float level = tone(from[x] * exposure * passed);
      const float noise = Noise(row_key + static_cast<uint64_t>(x));
      const float noisy = level + noise * std::sqrt(read + shot * level);
      to[x] = static_cast<uint8_t>(std::clamp(noisy + 0.5F, 0.0F, 255.0F));
    }
  });
  return grey;
}

}  // namespace corbslam

#include "services/simulation/sequence/depth_image.h"

#include <cmath>
#include <opencv2/core.hpp>

#include "services/simulation/dice.h"

namespace corbslam {

cv::Mat MakeDepthImage(const cv::Mat& depth_m, const DepthImageOptions& options, uint64_t stream) {
  constexpr uint64_t kPurpose = 0x6465707468;
  cv::Mat noise(depth_m.size(), CV_32FC1, cv::Scalar(0));
  if (options.noise_m > 0) {
    const uint64_t seed =
        Dice::For(options.noise_seed, kPurpose, static_cast<int64_t>(stream)).Next();
    cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, options.noise_m);
  }
  cv::Mat image(depth_m.size(), CV_16UC1, cv::Scalar(0));
  for (int row = 0; row < image.rows; ++row) {
    const float* depths = depth_m.ptr<float>(row);
    const float* noises = noise.ptr<float>(row);
    auto* units = image.ptr<uint16_t>(row);
    for (int column = 0; column < image.cols; ++column) {
      const double depth = depths[column];
      if (!(depth >= options.nearest_m && depth <= options.farthest_m)) continue;
      const double measured = depth + noises[column] * depth * depth;
      units[column] = cv::saturate_cast<uint16_t>(measured * options.units_per_m);
    }
  }
  return image;
}

}  // namespace corbslam

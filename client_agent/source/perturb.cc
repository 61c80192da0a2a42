#include "client_agent/source/perturb.h"

#include <cmath>
#include <opencv2/core.hpp>

#include "absl/strings/str_cat.h"
#include "slam/util/mixed_bits.h"

namespace corbslam::client_agent {
namespace {

// Neighbouring streams have nothing in common.
uint64_t Mix(uint64_t seed, uint64_t stream) { return MixBits(seed * kGoldenGamma + stream + 1); }

cv::Mat ApplyGamma(const cv::Mat& image, double gamma) {
  cv::Mat table(1, 256, CV_8UC1);
  for (int grey = 0; grey < 256; ++grey) {
    table.at<uint8_t>(grey) = cv::saturate_cast<uint8_t>(255 * std::pow(grey / 255.0, gamma));
  }
  cv::Mat result;
  cv::LUT(image, table, result);
  return result;
}

cv::Mat AddNoise(const cv::Mat& image, double sigma, uint64_t seed) {
  cv::Mat noise(image.size(), CV_32FC1);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::Mat result;
  cv::add(image, noise, result, cv::noArray(), CV_8UC1);
  return result;
}

}  // namespace

cv::Mat Perturb(const cv::Mat& image, const Perturbation& perturbation, uint64_t stream) {
  cv::Mat result = image;
  if (perturbation.gamma != 1.0) result = ApplyGamma(result, perturbation.gamma);
  if (perturbation.noise_sigma > 0) {
    result = AddNoise(result, perturbation.noise_sigma, Mix(perturbation.seed, stream));
  }
  return result;
}

absl::Status PerturbImages(const Perturbation& perturbation, size_t number, SensorImages& images) {
  try {
    images.grey = Perturb(images.grey, perturbation, 2 * number);
    if (!images.right.empty()) images.right = Perturb(images.right, perturbation, 2 * number + 1);
  } catch (const cv::Exception& exception) {
    return absl::InternalError(absl::StrCat("frame ", number, ": ", exception.what()));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::client_agent

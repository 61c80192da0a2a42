#include "slam/features/orb_extractor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "slam/features/corner_spread.h"
#include "slam/features/feature_limits.h"
#include "slam/features/gaussian_blur.h"
#include "slam/features/pixel_kernels.h"
#include "slam/features/steered_brief.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

constexpr int kMinImageSide_px = 64;
// The margin is a keypoint's patch and one pixel more.
constexpr int kMargin_px = kBriefRadius_px + 1;
constexpr int kMinLevelSide_px = 2 * kMargin_px + 8;

absl::Status CheckRange(absl::string_view field, int value, int low, int high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("orb.", field, " is ", value, ", must be in [", low, ", ", high, "]"));
}

// Splits the features in proportion to the levels' sides, so that as many levels see a structure
// from near as from far.
std::array<int, ScalePyramid::kLevels> SplitOverLevels(int features) {
  double sum = 0;
  for (int i = 0; i < ScalePyramid::kLevels; ++i) sum += 1 / ScalePyramid::Scale(i);
  std::array<int, ScalePyramid::kLevels> wanted = {};
  int given = 0;
  for (int i = ScalePyramid::kLevels - 1; i > 0; --i) {
    wanted[static_cast<size_t>(i)] =
        static_cast<int>(std::lround(features / (ScalePyramid::Scale(i) * sum)));
    given += wanted[static_cast<size_t>(i)];
  }
  wanted[0] = std::max(0, features - given);
  return wanted;
}

absl::Status OpenCvError(const cv::Exception& error) {
  return absl::InternalError(absl::StrCat("ORB extraction: OpenCV: ", error.what()));
}

const SteeredBrief& SystemBrief() {
  static const SteeredBrief* const brief = new SteeredBrief(LearnedBriefPattern());
  return *brief;
}

}  // namespace

absl::Status OrbOptions::Validate() const {
  absl::Status status = CheckRange("features", features, kLeastFeatures, kMostFeatures);
  status.Update(CheckRange("fast_threshold", fast_threshold, 2, 200));
  status.Update(CheckRange("min_fast_threshold", min_fast_threshold, 1, fast_threshold));
  status.Update(CheckRange("cell_px", cell_px, 8, 512));
  return status;
}

double ImagePyramid::ScaleX(int octave) const {
  return static_cast<double>(levels[0].cols) / levels[static_cast<size_t>(octave)].cols;
}
double ImagePyramid::ScaleY(int octave) const {
  return static_cast<double>(levels[0].rows) / levels[static_cast<size_t>(octave)].rows;
}
float ImagePyramid::ToLevel0X(float x_px, int octave) const {
  return static_cast<float>((x_px + 0.5) * ScaleX(octave) - 0.5);
}
float ImagePyramid::ToLevel0Y(float y_px, int octave) const {
  return static_cast<float>((y_px + 0.5) * ScaleY(octave) - 0.5);
}
float ImagePyramid::FromLevel0X(float x_px, int octave) const {
  return static_cast<float>((x_px + 0.5) / ScaleX(octave) - 0.5);
}
float ImagePyramid::FromLevel0Y(float y_px, int octave) const {
  return static_cast<float>((y_px + 0.5) / ScaleY(octave) - 0.5);
}

void BuildImagePyramid(const cv::Mat& grey, ImagePyramid& pyramid) {
  pyramid.levels[0] = grey;
  for (int octave = 1; octave < ScalePyramid::kLevels; ++octave) {
    const double scale = ScalePyramid::Scale(octave);
    const cv::Size size(static_cast<int>(std::lround(grey.cols / scale)),
                        static_cast<int>(std::lround(grey.rows / scale)));
    cv::Mat& level = pyramid.levels[static_cast<size_t>(octave)];
    if (std::min(size.width, size.height) < kMinLevelSide_px) {
      level.release();
    } else {
      cv::resize(pyramid.levels[static_cast<size_t>(octave) - 1], level, size, 0, 0,
                 cv::INTER_LINEAR);
    }
  }
}

OrbExtractor::OrbExtractor(const OrbOptions& options) : options_(options) {
  const auto wanted = SplitOverLevels(options.features);
  for (size_t i = 0; i < levels_.size(); ++i) levels_[i].wanted = wanted[i];
}

absl::Status OrbExtractor::Extract(const cv::Mat& grey, Features& features, ImagePyramid& pyramid) {
  RETURN_IF_ERROR(Begin(grey, pyramid));
  for (int octave = 0; octave < ScalePyramid::kLevels; ++octave) ExtractLevel(pyramid, octave);
  return Gather(features);
}

absl::Status OrbExtractor::Begin(const cv::Mat& grey, ImagePyramid& pyramid) {
  if (grey.type() != CV_8UC1 || std::min(grey.cols, grey.rows) < kMinImageSide_px) {
    return absl::InvalidArgumentError(
        absl::StrCat("ORB extraction needs a grey image of 8 bits and at least ", kMinImageSide_px,
                     "x", kMinImageSide_px, " pixels, given ", grey.cols, "x", grey.rows, " of ",
                     grey.channels(), " channels and OpenCV depth ", grey.depth()));
  }
  try {
    BuildImagePyramid(grey, pyramid);
  } catch (const cv::Exception& error) {
    return OpenCvError(error);
  }
  return absl::OkStatus();
}

void OrbExtractor::ExtractLevel(const ImagePyramid& pyramid, int octave) {
  Level& level = levels_[static_cast<size_t>(octave)];
  level.features.keypoints.clear();
  level.features.descriptors.clear();
  level.status = absl::OkStatus();
  if (pyramid.levels[static_cast<size_t>(octave)].empty()) return;
  try {
    Detect(pyramid, octave, level);
    Describe(pyramid, octave, level);
  } catch (const cv::Exception& error) {
    level.status = OpenCvError(error);
  }
}

absl::Status OrbExtractor::Gather(Features& features) const {
  features.keypoints.clear();
  features.descriptors.clear();
  for (const Level& level : levels_) {
    RETURN_IF_ERROR(level.status);
    const auto& [keypoints, descriptors] = level.features;
    features.keypoints.insert(features.keypoints.end(), keypoints.begin(), keypoints.end());
    features.descriptors.insert(features.descriptors.end(), descriptors.begin(), descriptors.end());
  }
  return absl::OkStatus();
}

void OrbExtractor::DropMasked(const ImagePyramid& pyramid, int octave,
                              std::vector<Corner>& corners) const {
  const auto is_masked = [&](const Corner& corner) {
    const int x = static_cast<int>(std::lround(pyramid.ToLevel0X(corner.x_px, octave)));
    const int y = static_cast<int>(std::lround(pyramid.ToLevel0Y(corner.y_px, octave)));
    return mask_.at<uint8_t>(std::clamp(y, 0, mask_.rows - 1), std::clamp(x, 0, mask_.cols - 1)) ==
           0;
  };
  corners.erase(std::remove_if(corners.begin(), corners.end(), is_masked), corners.end());
}

void OrbExtractor::Detect(const ImagePyramid& pyramid, int octave, Level& level) const {
  const cv::Mat& image = pyramid.levels[static_cast<size_t>(octave)];
  const FastOptions options = {.threshold = options_.fast_threshold,
                               .min_threshold = options_.min_fast_threshold,
                               .cell_px = options_.cell_px,
                               .margin_px = kMargin_px};
  level.detector.Detect(image, options, level.corners);
  if (!mask_.empty()) DropMasked(pyramid, octave, level.corners);
  SpreadCorners(image.cols, image.rows, level.wanted, level.corners);
}

void OrbExtractor::Describe(const ImagePyramid& pyramid, int octave, Level& level) {
  const cv::Mat& image = pyramid.levels[static_cast<size_t>(octave)];
  const PixelKernels& kernels = BestPixelKernels();
  const SteeredBrief& brief = SystemBrief();
  BlurGaussian7x7(image, level.blurred);
  for (const Corner& corner : level.corners) {
    const PatchMoments moments = kernels.patch_moments(
        image.ptr<uint8_t>(corner.y_px) + corner.x_px, static_cast<int64_t>(image.step[0]));
    Keypoint keypoint;
    keypoint.x_px = pyramid.ToLevel0X(corner.x_px, octave);
    keypoint.y_px = pyramid.ToLevel0Y(corner.y_px, octave);
    keypoint.angle_rad =
        std::atan2(static_cast<float>(moments.m01), static_cast<float>(moments.m10));
    keypoint.octave = static_cast<uint8_t>(octave);
    level.features.keypoints.push_back(keypoint);
    level.features.descriptors.push_back(
        brief.Describe(level.blurred, corner.x_px, corner.y_px, keypoint.angle_rad));
  }
}

}  // namespace corbslam

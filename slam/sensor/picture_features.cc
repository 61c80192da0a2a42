#include "slam/sensor/picture_features.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "slam/features/orb_extractor.h"
#include "slam/sensor/picture_header.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

absl::Status CheckSize(const cv::Size& size) {
  if (size.width < kMinPictureSide_px || size.height < kMinPictureSide_px ||
      int64_t{size.width} * size.height > kMaxPicturePixels) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the picture has ", size.width, "x", size.height, " pixels, must have at least ",
        kMinPictureSide_px, " on a side and ", kMaxPicturePixels, " in all"));
  }
  return absl::OkStatus();
}

// Leaves out what the pinhole does not see, or sees far outside of the picture.
void MoveToPinhole(const LensModel& lens, const Camera& camera, Features& features) {
  size_t kept = 0;
  for (size_t i = 0; i < features.keypoints.size(); ++i) {
    const std::optional<Eigen::Vector2d> ideal =
        UndistortPixel(camera, lens, features.keypoints[i].Pixel());
    if (!ideal.has_value() || ideal->x() < -camera.width_px || ideal->x() > 2 * camera.width_px ||
        ideal->y() < -camera.height_px || ideal->y() > 2 * camera.height_px) {
      continue;
    }
    features.keypoints[kept] = features.keypoints[i];
    features.keypoints[kept].x_px = static_cast<float>(ideal->x());
    features.keypoints[kept].y_px = static_cast<float>(ideal->y());
    features.descriptors[kept++] = features.descriptors[i];
  }
  features.keypoints.resize(kept);
  features.descriptors.resize(kept);
}

// Cameras of 10 or 12 bits write 16, of which the upper 8 show next to nothing: those of the
// brightest pixel count.
cv::Mat EightBits(const cv::Mat& grey) {
  if (grey.type() != CV_16UC1) return grey;
  double brightest = 0;
  cv::minMaxLoc(grey, nullptr, &brightest);
  const int shift =
      std::max(static_cast<int>(std::bit_width(static_cast<uint32_t>(brightest))) - 8, 0);
  cv::Mat eight(grey.size(), CV_8UC1);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      eight.at<uint8_t>(y, x) = static_cast<uint8_t>(grey.at<uint16_t>(y, x) >> shift);
    }
  }
  return eight;
}

bool IsPinhole(const LensModel& lens) {
  const auto* distortion = std::get_if<RadialTangential>(&lens);
  return distortion != nullptr && distortion->IsZero();
}

}  // namespace

absl::StatusOr<cv::Mat> DecodePicture(absl::string_view encoded) {
  if (encoded.empty() || encoded.size() > kMaxEncodedBytes) {
    return absl::InvalidArgumentError(absl::StrCat("the picture has ", encoded.size(),
                                                   " bytes, must have 1 to ", kMaxEncodedBytes));
  }
  ASSIGN_OR_RETURN(const cv::Size size, PictureSize(encoded));
  RETURN_IF_ERROR(CheckSize(size));
  if (IsCutShort(encoded)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the picture is cut short after ", encoded.size(), " bytes"));
  }
  const cv::Mat data(1, static_cast<int>(encoded.size()), CV_8UC1,
                     const_cast<char*>(encoded.data()));  // The bytes are only read.
  try {
    cv::Mat grey = EightBits(cv::imdecode(
        data, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION));
    if (grey.type() == CV_8UC1 && grey.size() == size) return grey;
  } catch (const cv::Exception& exception) {
    return absl::InvalidArgumentError(
        absl::StrCat("the picture can't be decoded: ", exception.err));
  }
  return absl::InvalidArgumentError("the picture can't be decoded");
}

absl::StatusOr<PictureFeatures> FindPictureFeatures(const cv::Mat& grey, const RawCamera& lens,
                                                    int wanted) {
  RETURN_IF_ERROR(CheckSize(grey.size()));
  if (wanted < kMinPictureFeatures || wanted > kMaxPictureFeatures) {
    return absl::InvalidArgumentError(absl::StrCat(
        "features is ", wanted, ", must be ", kMinPictureFeatures, " to ", kMaxPictureFeatures));
  }
  PictureFeatures found;
  found.camera = {.fx_px = lens.fx_px,
                  .fy_px = lens.fy_px,
                  .cx_px = lens.cx_px,
                  .cy_px = lens.cy_px,
                  .width_px = grey.cols,
                  .height_px = grey.rows};
  RETURN_IF_ERROR(Validate(found.camera));
  RETURN_IF_ERROR(Validate(lens.lens));
  OrbExtractor extractor({.features = wanted});
  ImagePyramid pyramid;
  RETURN_IF_ERROR(extractor.Extract(grey, found.features, pyramid));
  if (!IsPinhole(lens.lens)) MoveToPinhole(lens.lens, found.camera, found.features);
  return found;
}

}  // namespace corbslam

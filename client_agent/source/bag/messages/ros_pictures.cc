#include "client_agent/source/bag/messages/ros_pictures.h"

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/messages/compressed_depth.h"
#include "client_agent/source/pictures/image_file.h"
#include "slam/sensor/picture_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr uint32_t kMostSide_px = 16'384;
constexpr int64_t kMostPixels = int64_t{1} << 27;
constexpr int kNoConversion = -1;

// How pixels of an encoding lie in memory, and OpenCV's code that makes them grey.
struct PixelForm {
  absl::string_view encoding;
  int type;
  int to_grey = kNoConversion;
};

// ROS names Bayer patterns by their first four pixels, OpenCV by the second row's.
constexpr PixelForm kPixelForms[] = {
    {"mono8", CV_8UC1},
    {"8UC1", CV_8UC1},
    {"mono16", CV_16UC1},
    {"16UC1", CV_16UC1},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY},
    {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY},
    {"8UC4", CV_8UC4, cv::COLOR_BGRA2GRAY},
    {"rgb16", CV_16UC3, cv::COLOR_RGB2GRAY},
    {"bgr16", CV_16UC3, cv::COLOR_BGR2GRAY},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2GRAY},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY},
    {"uyvy", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2},
    {"yuyv", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2},
    {"nv12", CV_8UC1},  // Brightness comes first, then what colours it.
    {"nv21", CV_8UC1},
    {"nv24", CV_8UC1},
};
constexpr PixelForm kDepthForms[] = {
    {"16UC1", CV_16UC1}, {"mono16", CV_16UC1}, {"32FC1", CV_32FC1}};

template <size_t count>
const PixelForm* FindForm(const PixelForm (&forms)[count], absl::string_view encoding) {
  const PixelForm* const found = std::find_if(
      std::begin(forms), std::end(forms),
      [&](const PixelForm& form) { return absl::EqualsIgnoreCase(form.encoding, encoding); });
  return found == std::end(forms) ? nullptr : found;
}

template <size_t count>
absl::Status UnknownEncoding(const PixelForm (&forms)[count], absl::string_view encoding) {
  std::string known;
  for (const PixelForm& form : forms) {
    absl::StrAppend(&known, known.empty() ? "" : ", ", form.encoding);
  }
  return absl::InvalidArgumentError(absl::StrCat("encoding is '", encoding, "', read are ", known));
}

void SwapBytes(cv::Mat& pixels) {
  const size_t size = pixels.elemSize1();
  for (int y = 0; y < pixels.rows; ++y) {
    uint8_t* const row = pixels.ptr(y);
    const size_t bytes = static_cast<size_t>(pixels.cols) * pixels.elemSize();
    for (size_t at = 0; at < bytes; at += size) std::reverse(row + at, row + at + size);
  }
}

// Returns the pixels as they lie in the message.
absl::StatusOr<cv::Mat> PixelsOf(const RosImage& image, int type) {
  if (image.width_px == 0 || image.height_px == 0 || image.width_px > kMostSide_px ||
      image.height_px > kMostSide_px) {
    return absl::InvalidArgumentError(absl::StrCat("width, height are ", image.width_px, ", ",
                                                   image.height_px, ", must be 1 to ",
                                                   kMostSide_px));
  }
  const size_t row = image.width_px * static_cast<size_t>(CV_ELEM_SIZE(type));
  if (image.step < row) {
    return absl::InvalidArgumentError(absl::StrCat("step is ", image.step, ", a row of ",
                                                   image.width_px, " pixels has ", row, " bytes"));
  }
  // The last row may end with its pixels.
  const uint64_t bytes = uint64_t{image.step} * (image.height_px - 1) + row;
  if (image.data.size() < bytes) {
    return absl::InvalidArgumentError(absl::StrCat("data has ", image.data.size(), " bytes, ",
                                                   image.height_px, " rows of ", image.step,
                                                   " are announced"));
  }
  cv::Mat pixels(static_cast<int>(image.height_px), static_cast<int>(image.width_px), type);
  for (int y = 0; y < pixels.rows; ++y) {
    std::memcpy(pixels.ptr(y), image.data.data() + size_t{image.step} * static_cast<size_t>(y),
                row);
  }
  if (image.is_big_endian && pixels.elemSize1() > 1) SwapBytes(pixels);
  return pixels;
}

absl::Status CheckPixels(absl::string_view encoded) {
  ASSIGN_OR_RETURN(const cv::Size size, PictureSize(encoded));
  if (int64_t{size.width} * size.height <= kMostPixels) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("data is a picture of ", size.width, "x", size.height, " pixels"));
}

bool IsCompressedDepth(absl::string_view format) {
  return absl::StrContains(format, "compressedDepth");
}

}  // namespace

RosPictureForm FormOf(const RosImage& image) {
  return {image.encoding,
          {static_cast<int>(std::min(image.width_px, kMostSide_px)),
           static_cast<int>(std::min(image.height_px, kMostSide_px))},
          FindForm(kPixelForms, image.encoding) != nullptr,
          FindForm(kDepthForms, image.encoding) != nullptr};
}

RosPictureForm FormOf(const RosCompressedImage& image) {
  RosPictureForm form;
  form.encoding = image.format;
  const bool is_depth = IsCompressedDepth(image.format);
  const auto size = is_depth ? CompressedDepthSize(image) : PictureSize(image.data);
  if (size.ok()) form.size = *size;
  const bool has_16_bits = absl::StartsWith(image.format, "16UC1");
  form.can_be_depth = is_depth || has_16_bits;
  form.can_be_grey = size.ok() && !is_depth;
  return form;
}

absl::StatusOr<cv::Mat> GreyOf(const RosImage& image) {
  const PixelForm* const form = FindForm(kPixelForms, image.encoding);
  if (form == nullptr) return UnknownEncoding(kPixelForms, image.encoding);
  ASSIGN_OR_RETURN(cv::Mat pixels, PixelsOf(image, form->type));
  if (form->to_grey == kNoConversion) return pixels;
  try {
    cv::Mat grey;
    cv::cvtColor(pixels, grey, form->to_grey);
    return grey;
  } catch (const cv::Exception& exception) {  // A Bayer pattern of one row, half a pair of YUV.
    return absl::InvalidArgumentError(
        absl::StrCat("encoding ", image.encoding, ": ", exception.what()));
  }
}

absl::StatusOr<cv::Mat> GreyOf(const RosCompressedImage& image) {
  RETURN_IF_ERROR(CheckPixels(image.data));
  return DecodeGreyImage(image.data, absl::StrCat("format ", image.format));
}

absl::StatusOr<cv::Mat> DepthOf(const RosImage& image) {
  const PixelForm* const form = FindForm(kDepthForms, image.encoding);
  if (form == nullptr) return UnknownEncoding(kDepthForms, image.encoding);
  return PixelsOf(image, form->type);
}

absl::StatusOr<cv::Mat> DepthOf(const RosCompressedImage& image) {
  if (IsCompressedDepth(image.format)) return UnpackCompressedDepth(image);
  RETURN_IF_ERROR(CheckPixels(image.data));
  return DecodeDepthImage(image.data, absl::StrCat("format ", image.format));
}

}  // namespace corbslam::client_agent

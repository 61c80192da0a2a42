#include "client_agent/source/pictures/mask_picture.h"

#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/pictures/image_file.h"
#include "slam/sensor/picture_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr double kMostMasked_percent = 95;

absl::Status NoMask(absl::string_view name, absl::string_view why) {
  return absl::InvalidArgumentError(absl::StrCat(name, ": ", why));
}

absl::StatusOr<cv::Mat> DecodeAsStored(absl::string_view name, const std::string& encoded) {
  if (encoded.empty() || encoded.size() > static_cast<size_t>(std::numeric_limits<int>::max()) ||
      IsCutShort(encoded)) {
    return NoMask(name, absl::StrCat("the picture is cut short after ", encoded.size(), " bytes"));
  }
  // OpenCV reads from the bytes alone. It throws for pictures beyond its limits.
  const cv::Mat bytes(1, static_cast<int>(encoded.size()), CV_8UC1,
                      const_cast<char*>(encoded.data()));
  try {
    cv::Mat mask = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
    if (!mask.empty()) return mask;
  } catch (const cv::Exception& error) {
    return NoMask(name, absl::StrCat("can't be decoded: ", error.err));
  }
  return NoMask(name, "can't be decoded");
}

// Returns the one channel of a picture that is grey, whatever it is stored as.
absl::StatusOr<cv::Mat> OneChannel(absl::string_view name, const cv::Mat& picture) {
  if (picture.depth() != CV_8U) {
    return NoMask(name,
                  absl::StrCat("a mask of ", 8 * picture.elemSize1(), " bits: write one of 8"));
  }
  if (picture.channels() == 1) return picture;
  if (picture.channels() != 3) {
    return NoMask(name,
                  "a mask with an alpha channel, which is not looked at: write it without one, "
                  "black (0) where the robot is seen and white (255) elsewhere");
  }
  std::vector<cv::Mat> channels;
  cv::split(picture, channels);
  if (cv::countNonZero(channels[0] != channels[1]) == 0 &&
      cv::countNonZero(channels[0] != channels[2]) == 0) {
    return channels[0];
  }
  return NoMask(name, "a mask in colours: write it in black (0) and white (255)");
}

absl::Status CheckValues(absl::string_view name, const cv::Mat& mask) {
  const cv::Mat other = (mask != 0) & (mask != 255);
  const int count = cv::countNonZero(other);
  if (count > 0) {
    double least = 0;
    cv::minMaxLoc(mask, &least, nullptr, nullptr, nullptr, other);
    return NoMask(name, absl::StrCat("a mask with the value ", least, " (", count,
                                     " pixels are neither 0 nor 255): write it in 0, where the "
                                     "robot is seen, and 255, without smoothing, as PNG"));
  }
  const double percent = MaskedPercent(mask);
  if (percent <= kMostMasked_percent) return absl::OkStatus();
  return NoMask(name, absl::StrFormat("the mask leaves out %.1f %% of the picture, at most %.0f %% "
                                      "can be: is it inverted? It is black (0) where the robot is "
                                      "seen and white (255) elsewhere",
                                      percent, kMostMasked_percent));
}

}  // namespace

double MaskedPercent(const PictureMask& mask) {
  if (mask.empty()) return 0;
  const auto total = static_cast<double>(mask.total());
  return 100 * (total - cv::countNonZero(mask)) / total;
}

double MaskedPercent(const SensorCalibration& calibration) {
  return std::visit([](const auto& kind) { return MaskedPercent(kind.mask); }, calibration);
}

absl::StatusOr<PictureMask> DecodeMaskPicture(absl::string_view name, const std::string& encoded) {
  ASSIGN_OR_RETURN(const cv::Mat stored, DecodeAsStored(name, encoded));
  ASSIGN_OR_RETURN(cv::Mat mask, OneChannel(name, stored));
  RETURN_IF_ERROR(CheckValues(name, mask));
  return mask;
}

absl::StatusOr<PictureMask> ReadMaskPicture(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadPictureBytes(path));
  return DecodeMaskPicture(path, bytes);
}

}  // namespace corbslam::client_agent

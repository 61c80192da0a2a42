#include "client_agent/source/pictures/image_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/sensor/picture_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kFirstPictures = 10;

absl::StatusOr<cv::Mat> DecodeImage(absl::string_view bytes, absl::string_view name, int flags) {
  if (IsCutShort(bytes)) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": the picture is cut short after ", bytes.size(), " bytes"));
  }
  if (bytes.empty() || bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", bytes.size(), " bytes"));
  }
  const cv::Mat data(1, static_cast<int>(bytes.size()), CV_8UC1,
                     const_cast<char*>(bytes.data()));  // The bytes are only read.
  try {
    cv::Mat image = cv::imdecode(data, flags);
    if (!image.empty()) return image;
  } catch (const cv::Exception& exception) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", exception.what()));
  }
  return absl::InvalidArgumentError(absl::StrCat(name, ": no picture that can be read"));
}

}  // namespace

absl::StatusOr<std::string> ReadPictureBytes(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return absl::NotFoundError(absl::StrCat("no picture ", path));
  }
  const uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": can't be read"));
  }
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (file.gcount() != static_cast<std::streamsize>(size) || bytes.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": an empty file"));
  }
  return bytes;
}

absl::StatusOr<cv::Mat> ReadGreyImage(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadPictureBytes(path));
  return DecodeGreyImage(bytes, path);
}

absl::StatusOr<cv::Mat> DecodeGreyImage(absl::string_view bytes, absl::string_view name) {
  ASSIGN_OR_RETURN(cv::Mat image, DecodeImage(bytes, name,
                                              cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH |
                                                  cv::IMREAD_IGNORE_ORIENTATION));
  if (image.type() == CV_8UC1 || image.type() == CV_16UC1) return image;
  return absl::InvalidArgumentError(
      absl::StrCat(name, ": a picture has 8 or 16 bits, this one is of OpenCV type ",
                   cv::typeToString(image.type())));
}

absl::StatusOr<cv::Mat> ReadFirstGrey(const std::vector<std::string>& paths) {
  absl::Status first_error;
  for (size_t i = 0; i < std::min(kFirstPictures, paths.size()); ++i) {
    absl::StatusOr<cv::Mat> image = ReadGreyImage(paths[i]);
    if (image.ok()) return image;
    if (first_error.ok()) first_error = image.status();
  }
  return first_error;
}

absl::StatusOr<cv::Mat> ReadDepthImage(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadPictureBytes(path));
  return DecodeDepthImage(bytes, path);
}

absl::StatusOr<cv::Mat> DecodeDepthImage(absl::string_view bytes, absl::string_view name) {
  ASSIGN_OR_RETURN(cv::Mat image, DecodeImage(bytes, name, cv::IMREAD_UNCHANGED));
  if (image.type() != CV_16UC1) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, ": a depth image has one channel of 16 bits, this one is of OpenCV type ",
        cv::typeToString(image.type())));
  }
  return image;
}

}  // namespace corbslam::client_agent

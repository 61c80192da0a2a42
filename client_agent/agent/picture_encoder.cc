#include "client_agent/agent/picture_encoder.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/exchange/uplink.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int kQuality = 65;
constexpr int kLeastQuality = 20;
// A picture of width_px at this form has the pixels that pictures of other forms have, too.
constexpr double kHeightOfWidth = 0.75;

// Returns for each pixel of the undistorted picture where the lens has put it.
cv::Mat UndistortionOf(const Camera& camera, const LensModel& lens) {
  const RawCamera raw{camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, lens};
  cv::Mat places(camera.height_px, camera.width_px, CV_32FC2);
  for (int y = 0; y < places.rows; ++y) {
    for (int x = 0; x < places.cols; ++x) {
      const Eigen::Vector3d direction((x - camera.cx_px) / camera.fx_px,
                                      (y - camera.cy_px) / camera.fy_px, 1);
      // What the lens doesn't see is black.
      const Eigen::Vector2d place =
          ProjectRaw(raw, direction).value_or(Eigen::Vector2d(-1e4, -1e4));
      places.at<cv::Vec2f>(y, x) = {static_cast<float>(place.x()), static_cast<float>(place.y())};
    }
  }
  return places;
}

bool Distorts(const LensModel& lens) { return !(lens == LensModel(RadialTangential())); }

double ScaleOf(const cv::Mat& grey, int width_px) {
  const double pixels = kHeightOfWidth * width_px * width_px;
  const double scale = std::sqrt(static_cast<double>(grey.cols) * grey.rows / pixels);
  // The picture has a whole number of columns.
  const double columns = std::max(std::round(grey.cols / std::max(scale, 1.0)), 1.0);
  return grey.cols / columns;
}

std::string EncodeJpeg(const cv::Mat& picture, int quality) {
  std::vector<uchar> bytes;
  cv::imencode(".jpg", picture, bytes,
               {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_OPTIMIZE, 1});
  return {bytes.begin(), bytes.end()};
}

}  // namespace

absl::StatusOr<PictureEncoder> PictureEncoder::Make(const SensorCalibration& calibration,
                                                    int width_px) {
  if (width_px < 1) {
    return absl::InvalidArgumentError(absl::StrCat("picture width is ", width_px));
  }
  PictureEncoder encoder(width_px);
  if (const auto* stereo = std::get_if<StereoCalibration>(&calibration)) {
    if (!stereo->raw.has_value()) return encoder;
    ASSIGN_OR_RETURN(encoder.rectifier_, StereoRectifier::Make(*stereo->raw));
    return encoder;
  }
  const MonocularCalibration one = FirstCameraOf(calibration);
  RETURN_IF_ERROR(Validate(one.camera));
  if (Distorts(one.lens)) encoder.undistortion_ = UndistortionOf(one.camera, one.lens);
  return encoder;
}

absl::StatusOr<cv::Mat> PictureEncoder::Undistort(const cv::Mat& grey) const {
  cv::Mat undistorted = grey;
  if (rectifier_.has_value()) {
    undistorted = cv::Mat();
    RETURN_IF_ERROR(rectifier_->RectifyLeft(grey, undistorted));
  } else if (!undistortion_.empty()) {
    cv::remap(grey, undistorted, undistortion_, cv::noArray(), cv::INTER_LINEAR);
  }
  return undistorted;
}

absl::StatusOr<PictureEncoder::Encoded> PictureEncoder::Encode(const cv::Mat& grey) const {
  try {
    ASSIGN_OR_RETURN(const cv::Mat undistorted, Undistort(grey));
    Encoded encoded;
    encoded.scale = ScaleOf(undistorted, width_px_);
    const auto scaled = [&](int pixels) {
      return std::max(static_cast<int>(std::lround(pixels / encoded.scale)), 1);
    };
    cv::Mat small = undistorted;
    if (encoded.scale > 1) {
      small = cv::Mat();
      cv::resize(undistorted, small, {scaled(undistorted.cols), scaled(undistorted.rows)}, 0, 0,
                 cv::INTER_AREA);
    }
    for (int quality = kQuality; quality >= kLeastQuality; quality -= 15) {
      encoded.jpeg = EncodeJpeg(small, quality);
      if (encoded.jpeg.size() <= kMaxPictureBytes) return encoded;
    }
    return absl::InternalError(absl::StrCat("a picture of ", small.cols, "x", small.rows,
                                            " pixels takes ", encoded.jpeg.size(), " bytes"));
  } catch (const std::exception& error) {
    return absl::InternalError(absl::StrCat("a keyframe's picture: ", error.what()));
  }
}

}  // namespace corbslam::client_agent

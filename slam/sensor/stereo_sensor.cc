#include "slam/sensor/stereo_sensor.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/sensor/image_check.h"
#include "slam/sensor/stereo_matching.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// The right image serves only to find counterparts: with more corners there, fewer of the left
// ones miss theirs because the spread over the image chose its neighbour.
constexpr int kRightFeaturesFactor = 2;

// Returns the image without its first `columns`; what is missing at the other side repeats its
// edge. A negative number moves it the other way.
cv::Mat DropColumns(const cv::Mat& image, int columns) {
  const int count = std::min(std::abs(columns), image.cols - 1);
  const cv::Range kept =
      columns > 0 ? cv::Range(count, image.cols) : cv::Range(0, image.cols - count);
  cv::Mat moved;
  cv::copyMakeBorder(image.colRange(kept), moved, 0, 0, columns > 0 ? 0 : count,
                     columns > 0 ? count : 0, cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  return moved;
}

OrbOptions OptionsOfRight(OrbOptions options) {
  options.features *= kRightFeaturesFactor;
  return options;
}

// Returns the mask of the recorded left picture as the sensor sees it. A pixel that is made of
// masked ones, too, is masked.
absl::StatusOr<cv::Mat> RectifiedMask(const PictureMask& mask, const Camera& camera,
                                      const std::optional<StereoRectifier>& rectifier) {
  RETURN_IF_ERROR(CheckMask(mask, camera));
  if (mask.empty() || !rectifier.has_value()) return mask;
  const cv::Mat used = (mask != 0);
  cv::Mat rectified;
  RETURN_IF_ERROR(rectifier->RectifyLeft(used, rectified));
  return cv::Mat(rectified == 255);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Sensor>> StereoSensor::Make(const StereoCalibration& calibration,
                                                           const SensorOptions& options) {
  Camera camera = calibration.camera;
  std::optional<StereoRectifier> rectifier;
  if (calibration.raw.has_value()) {
    ASSIGN_OR_RETURN(rectifier, StereoRectifier::Make(*calibration.raw));
    camera = rectifier->camera();
    if (calibration.camera.close_depth_m > 0) {
      camera.close_depth_m = calibration.camera.close_depth_m;
    }
  }
  RETURN_IF_ERROR(Validate(camera));
  if (!camera.IsMetric()) {
    return absl::InvalidArgumentError(
        absl::StrCat("camera.baseline_m is ", camera.baseline_m, ", must be > 0 for stereo"));
  }
  if (!(std::abs(calibration.right_cx_offset_px) < camera.width_px)) {
    return absl::InvalidArgumentError(
        absl::StrCat("right_cx_offset_px is ", calibration.right_cx_offset_px,
                     ", must be less than the picture's width of ", camera.width_px));
  }
  std::unique_ptr<StereoSensor> sensor(
      new StereoSensor(camera, std::move(rectifier), calibration.right_cx_offset_px, options));
  RETURN_IF_ERROR(sensor->SetMask(calibration.mask));
  return sensor;
}

StereoSensor::StereoSensor(const Camera& camera, std::optional<StereoRectifier> rectifier,
                           double right_cx_offset_px, const SensorOptions& options)
    : camera_(camera),
      rectifier_(std::move(rectifier)),
      right_columns_(static_cast<int>(std::lround(right_cx_offset_px))),
      right_rest_px_(right_cx_offset_px - right_columns_),
      left_(options.orb),
      right_(OptionsOfRight(options.orb)),
      threads_(options.parallel) {}

absl::Status StereoSensor::SetMask(const PictureMask& mask) {
  ASSIGN_OR_RETURN(const cv::Mat rectified, RectifiedMask(mask, camera_, rectifier_));
  mask_ = rectified;
  left_.extractor.SetMask(rectified);
  return absl::OkStatus();
}

absl::StatusOr<cv::Mat> StereoSensor::Picture(const SensorImages& images) {
  RETURN_IF_ERROR(CheckGreyImage("left", images.grey, camera_));
  RETURN_IF_ERROR(CheckGreyImage("right", images.right, camera_));
  if (!rectifier_.has_value()) return images.grey;
  RETURN_IF_ERROR(rectifier_->RectifyLeft(images.grey, picture_));
  return picture_;
}

std::optional<Eigen::Vector2d> StereoSensor::InPicture(const Eigen::Vector2d& ideal_px) const {
  if (!IsInImage(camera_, ideal_px) || IsMasked(mask_, ideal_px)) return std::nullopt;
  return ideal_px;
}

std::optional<Keypoint> StereoSensor::FromPicture(const SensorImages& /*images*/,
                                                  const Keypoint& in_picture) const {
  Keypoint keypoint = in_picture;
  keypoint.disparity_px = 0;
  return keypoint;
}

absl::StatusOr<Features> StereoSensor::Process(const SensorImages& images) {
  RETURN_IF_ERROR(CheckGreyImage("left", images.grey, camera_));
  RETURN_IF_ERROR(CheckGreyImage("right", images.right, camera_));
  threads_.Run(2, [&](size_t side) {
    if (side == 0) {
      right_.status = BeginRight(images.right);
    } else {
      left_.status = BeginLeft(images.grey);
    }
  });
  RETURN_IF_ERROR(left_.status);
  RETURN_IF_ERROR(right_.status);
  // The large levels come first, so that both threads end at about the same time.
  threads_.Run(2 * ScalePyramid::kLevels, [this](size_t i) {
    Side& side = i % 2 == 0 ? right_ : left_;
    side.extractor.ExtractLevel(side.pyramid, static_cast<int>(i / 2));
  });
  RETURN_IF_ERROR(right_.extractor.Gather(right_.features));
  Features features;
  RETURN_IF_ERROR(left_.extractor.Gather(features));
  rows_.Add(MatchStereo(right_.features, left_.pyramid, right_.pyramid,
                        {.max_disparity_px = camera_.fx_px, .disparity_offset_px = right_rest_px_},
                        threads_, features));
  return features;
}

absl::Status StereoSensor::BeginLeft(const cv::Mat& image) {
  if (!rectifier_.has_value()) return left_.extractor.Begin(image, left_.pyramid);
  RETURN_IF_ERROR(rectifier_->RectifyLeft(image, left_.rectified));
  return left_.extractor.Begin(left_.rectified, left_.pyramid);
}

absl::Status StereoSensor::BeginRight(const cv::Mat& image) {
  ASSIGN_OR_RETURN(const cv::Mat rectified, Rectified(image));
  const double rows_px = rows_.correction_px();
  return right_.extractor.Begin(rows_px == 0 ? rectified : MoveUp(rectified, rows_px),
                                right_.pyramid);
}

absl::StatusOr<cv::Mat> StereoSensor::Rectified(const cv::Mat& right) {
  if (!rectifier_.has_value()) {
    return right_columns_ == 0 ? right : DropColumns(right, right_columns_);
  }
  RETURN_IF_ERROR(rectifier_->RectifyRight(right, right_.rectified));
  return right_.rectified;
}

}  // namespace corbslam

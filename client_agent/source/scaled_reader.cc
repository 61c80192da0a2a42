#include "client_agent/source/scaled_reader.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/source/altered_reader.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int kLeastSide_px = 64;

// How much a picture's sides are scaled: by rounding to whole pixels, not quite alike.
struct Scaling {
  cv::Size size;
  double x = 1;
  double y = 1;
};

// Pixel centres are at whole numbers, so that the picture's corner is at -0.5.
double ScaledCentre(double centre_px, double scale) { return (centre_px + 0.5) * scale - 0.5; }

template <typename Intrinsics>
void ScaleIntrinsics(const Scaling& scaling, Intrinsics& camera) {
  camera.fx_px *= scaling.x;
  camera.fy_px *= scaling.y;
  camera.cx_px = ScaledCentre(camera.cx_px, scaling.x);
  camera.cy_px = ScaledCentre(camera.cy_px, scaling.y);
}

template <typename Sized>
void SetSize(const Scaling& scaling, Sized& sized) {
  sized.width_px = scaling.size.width;
  sized.height_px = scaling.size.height;
}

cv::Mat Nearest(const Scaling& scaling, const cv::Mat& image) {
  cv::Mat scaled;
  if (!image.empty()) cv::resize(image, scaled, scaling.size, 0, 0, cv::INTER_NEAREST);
  return scaled;
}

void Scale(const Scaling& scaling, StereoCalibration& calibration) {
  calibration.mask = Nearest(scaling, calibration.mask);
  calibration.right_cx_offset_px *= scaling.x;
  if (!calibration.raw.has_value()) {
    ScaleIntrinsics(scaling, calibration.camera);
    return SetSize(scaling, calibration.camera);
  }
  ScaleIntrinsics(scaling, calibration.raw->left);
  ScaleIntrinsics(scaling, calibration.raw->right);
  SetSize(scaling, *calibration.raw);
}

// Of an RGB-D camera or one camera alone.
template <typename OneCamera>
void Scale(const Scaling& scaling, OneCamera& calibration) {
  calibration.mask = Nearest(scaling, calibration.mask);
  ScaleIntrinsics(scaling, calibration.camera);
  SetSize(scaling, calibration.camera);
}

class ScaledReader : public AlteredReader {
 public:
  ScaledReader(std::unique_ptr<FrameReader> reader, const Scaling& scaling, double scale)
      : AlteredReader(std::move(reader)), scaling_(scaling) {
    description_.unscaled_px = {description_.intrinsics.width_px,
                                description_.intrinsics.height_px};
    std::visit([&](auto& kind) { Scale(scaling_, kind); }, calibration_);
    DescribeCamera(calibration_, description_);
    absl::StrAppend(&description_.layout, ", scaled by ", scale);
  }

  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    ASSIGN_OR_RETURN(const SensorImages read, reader().Read(frame));
    SensorImages images;
    images.timestamp_ns = read.timestamp_ns;
    images.grey = Smooth(read.grey);
    images.right = Smooth(read.right);
    images.depth = Nearest(scaling_, read.depth);
    images.imu = read.imu;
    return images;
  }

 private:
  cv::Mat Smooth(const cv::Mat& image) const {
    cv::Mat scaled;
    if (!image.empty()) cv::resize(image, scaled, scaling_.size, 0, 0, cv::INTER_AREA);
    return scaled;
  }

  const Scaling scaling_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameReader>> ScaleReader(std::unique_ptr<FrameReader> reader,
                                                         double scale) {
  const Intrinsics& raw = reader->description().intrinsics;
  Scaling scaling;
  scaling.size = {static_cast<int>(std::lround(raw.width_px * scale)),
                  static_cast<int>(std::lround(raw.height_px * scale))};
  if (std::min(scaling.size.width, scaling.size.height) < kLeastSide_px) {
    return absl::InvalidArgumentError(absl::StrCat(
        "?scale=", scale, " makes pictures of ", scaling.size.width, "x", scaling.size.height,
        " pixels, of which there must be ", kLeastSide_px, " a side"));
  }
  scaling.x = static_cast<double>(scaling.size.width) / raw.width_px;
  scaling.y = static_cast<double>(scaling.size.height) / raw.height_px;
  return std::make_unique<ScaledReader>(std::move(reader), scaling, scale);
}

}  // namespace corbslam::client_agent

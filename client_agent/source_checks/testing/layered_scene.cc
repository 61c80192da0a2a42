#include "client_agent/source_checks/testing/layered_scene.h"

#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace corbslam::client_agent {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 360;
constexpr double kFocal_px = 400;
constexpr double kBaseline_m = 0.1;
constexpr double kUnitsPerM = 5000;
constexpr int kCards = 24;
constexpr size_t kFrames = 60;
constexpr double kMoveX_baselines = 1.2;
constexpr double kMoveY_baselines = 1.0;

struct Card {
  cv::Mat texture;
  cv::Point corner;  // Place of its upper left pixel for a camera in the middle.
  int disparity_px = 0;
};

// The contrast is weaker than the steps of brightness from card to card, so that outlines are
// edges.
cv::Mat MakeTexture(const cv::Size& size, double contrast, cv::RNG& random) {
  cv::Mat coarse(size / 9 + cv::Size(2, 2), CV_8UC1);
  random.fill(coarse, cv::RNG::UNIFORM, 0, 256);
  cv::Mat texture;
  cv::resize(coarse, texture, size, 0, 0, cv::INTER_CUBIC);
  const double amplitude = 0.22 * contrast;
  const double brightness = 128 + contrast * random.uniform(-80.0, 80.0);
  texture.convertTo(texture, CV_8U, amplitude, brightness - 128 * amplitude);
  return texture;
}

class LayeredScene {
 public:
  explicit LayeredScene(const LayeredSceneOptions& options) : options_(options) {
    cv::RNG random(options.seed);
    // The background reaches beyond the picture on all sides.
    cards_.push_back({MakeTexture({2 * kWidth_px, 2 * kHeight_px}, options.contrast, random),
                      {-kWidth_px / 2, -kHeight_px / 2},
                      options.farthest_px});
    for (int i = 1; i <= kCards; ++i) {
      const int height = random.uniform(50, 120);  // Arguments are evaluated in any order.
      const cv::Size size(random.uniform(60, 160), height);
      cards_.push_back(
          {MakeTexture(size, options.contrast, random),
           {random.uniform(-40, kWidth_px), random.uniform(-40, kHeight_px)},
           options.farthest_px + (options.nearest_px - options.farthest_px) * i / kCards});
    }
  }

  // Draws what a camera sees that is `baselines` to the right of the left one.
  cv::Mat Grey(size_t frame, int baselines) const {
    cv::Mat picture(kHeight_px, kWidth_px, CV_8UC1);
    for (const Card& card : cards_) {
      const cv::Rect inside = Place(card, frame, baselines);
      if (inside.empty()) continue;
      const cv::Point corner = Corner(card, frame, baselines);
      card.texture(inside - corner).copyTo(picture(inside));
    }
    return AddNoise(picture, 2 * frame + static_cast<uint64_t>(baselines));
  }

  cv::Mat Depth(size_t frame) const {
    cv::Mat depth(kHeight_px, kWidth_px, CV_16UC1);
    for (const Card& card : cards_) {
      const double depth_m = kFocal_px * kBaseline_m / card.disparity_px;
      depth(Place(card, frame, 0)) = cv::Scalar::all(kUnitsPerM * depth_m);
    }
    // A depth camera has such a blind side.
    depth(cv::Rect(0, 0, 20, kHeight_px)) = cv::Scalar::all(0);
    return depth;
  }

 private:
  cv::Point Corner(const Card& card, size_t frame, int baselines) const {
    const auto time = static_cast<double>(frame);
    const double swing_x = options_.moving * std::sin(0.45 * time);
    const double swing_y = options_.moving * std::sin(0.37 * time + 1);
    const double right = kMoveX_baselines * swing_x * card.disparity_px;
    const double down = kMoveY_baselines * swing_y * card.disparity_px;
    return card.corner -
           cv::Point(static_cast<int>(std::lround(right)) + baselines * card.disparity_px,
                     static_cast<int>(std::lround(down)));
  }

  cv::Rect Place(const Card& card, size_t frame, int baselines) const {
    return cv::Rect(Corner(card, frame, baselines), card.texture.size()) &
           cv::Rect(0, 0, kWidth_px, kHeight_px);
  }

  cv::Mat AddNoise(const cv::Mat& picture, uint64_t stream) const {
    if (options_.noise <= 0) return picture;
    cv::Mat noise(picture.size(), CV_32FC1);
    cv::RNG(options_.seed * 1000 + stream + 1).fill(noise, cv::RNG::NORMAL, 0.0, options_.noise);
    cv::Mat result;
    cv::add(picture, noise, result, cv::noArray(), CV_8UC1);
    return result;
  }

  const LayeredSceneOptions options_;
  std::vector<Card> cards_;  // The farthest card comes first.
};

Camera MakeCamera() {
  Camera camera;
  camera.fx_px = kFocal_px;
  camera.fy_px = kFocal_px;
  camera.cx_px = kWidth_px / 2.0;
  camera.cy_px = kHeight_px / 2.0;
  camera.width_px = kWidth_px;
  camera.height_px = kHeight_px;
  camera.baseline_m = kBaseline_m;
  camera.close_depth_m = 10;
  return camera;
}

int64_t TimeOf(size_t frame) { return static_cast<int64_t>(frame) * 100'000'000; }

}  // namespace

SampleSource LayeredStereo(const LayeredSceneOptions& options) {
  const auto scene = std::make_shared<LayeredScene>(options);
  StereoCalibration calibration;
  calibration.camera = MakeCamera();
  return {calibration, kFrames, [scene](size_t frame) -> absl::StatusOr<SensorImages> {
            SensorImages images;
            images.timestamp_ns = TimeOf(frame);
            images.grey = scene->Grey(frame, 0);
            images.right = scene->Grey(frame, 1);
            return images;
          }};
}

SampleSource LayeredRgbd(const LayeredSceneOptions& options) {
  const auto scene = std::make_shared<LayeredScene>(options);
  RgbdCalibration calibration;
  calibration.camera = MakeCamera();
  calibration.depth_units_per_m = kUnitsPerM;
  return {calibration, kFrames, [scene](size_t frame) -> absl::StatusOr<SensorImages> {
            SensorImages images;
            images.timestamp_ns = TimeOf(frame);
            images.grey = scene->Grey(frame, 0);
            images.depth = scene->Depth(frame);
            return images;
          }};
}

}  // namespace corbslam::client_agent

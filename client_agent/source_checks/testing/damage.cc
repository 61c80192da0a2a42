#include "client_agent/source_checks/testing/damage.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

cv::Mat Shifted(const cv::Mat& image, double x_px, double y_px) {
  const cv::Mat map = (cv::Mat_<double>(2, 3) << 1, 0, x_px, 0, 1, y_px);
  cv::Mat result;
  cv::warpAffine(image, result, map, image.size(),
                 image.depth() == CV_8U ? cv::INTER_LINEAR : cv::INTER_NEAREST,
                 image.depth() == CV_8U ? cv::BORDER_REPLICATE : cv::BORDER_CONSTANT);
  return result;
}

cv::Mat Rolled(const cv::Mat& image, double degrees) {
  const cv::Mat map = cv::getRotationMatrix2D(
      cv::Point2f(static_cast<float>(image.cols) / 2, static_cast<float>(image.rows) / 2), degrees,
      1);
  cv::Mat result;
  cv::warpAffine(image, result, map, image.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return result;
}

cv::Mat Noisy(const cv::Mat& image, double sigma, uint64_t seed) {
  cv::Mat noise(image.size(), CV_32FC1);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::Mat result;
  cv::add(image, noise, result, cv::noArray(), image.type());
  return result;
}

cv::Mat Multiplied(const cv::Mat& image, double factor) {
  cv::Mat result;
  image.convertTo(result, image.type(), factor);
  return result;
}

using Edit = std::function<void(SensorImages&, double)>;

void EditGrey(SensorImages& images, double factor) {
  images.grey = Multiplied(images.grey, factor);
  if (!images.right.empty()) images.right = Multiplied(images.right, factor);
}

const std::map<std::string, Edit>& Edits() {
  static const auto& edits = *new std::map<std::string, Edit>{
      {"", [](SensorImages&, double) {}},
      {"exchanged", [](SensorImages& images, double) { std::swap(images.grey, images.right); }},
      {"same", [](SensorImages& images, double) { images.right = images.grey.clone(); }},
      {"rows",
       [](SensorImages& images, double px) { images.right = Shifted(images.right, 0, px); }},
      {"columns",
       [](SensorImages& images, double px) { images.right = Shifted(images.right, px, 0); }},
      {"roll",
       [](SensorImages& images, double degrees) { images.right = Rolled(images.right, degrees); }},
      {"mirrored", [](SensorImages& images, double) { cv::flip(images.right, images.right, 1); }},
      {"dark", [](SensorImages& images, double divisor) { EditGrey(images, 1 / divisor); }},
      {"bright", [](SensorImages& images, double factor) { EditGrey(images, factor); }},
      {"noise",
       [](SensorImages& images, double sigma) {
         const auto seed = static_cast<uint64_t>(images.timestamp_ns);
         images.grey = Noisy(images.grey, sigma, 2 * seed + 1);
         if (!images.right.empty()) images.right = Noisy(images.right, sigma, 2 * seed + 2);
       }},
      {"depth_scale", [](SensorImages& images,
                         double factor) { images.depth = Multiplied(images.depth, factor); }},
      {"depth_saturated",
       [](SensorImages& images, double) { images.depth.setTo(65535, images.depth == 0); }},
      {"depth_shift",
       [](SensorImages& images, double px) { images.depth = Shifted(images.depth, px, 0); }},
      {"depth_empty",
       [](SensorImages& images, double) {
         images.depth = cv::Mat::zeros(images.depth.size(), images.depth.type());
       }},
      {"depth_constant", [](SensorImages& images, double value) {
         images.depth = cv::Mat(images.depth.size(), images.depth.type(), cv::Scalar::all(value));
       }}};
  return edits;
}

}  // namespace

ReadFrame Damage(ReadFrame read, const std::string& name, double amount) {
  return [read = std::move(read), name, amount](size_t frame) -> absl::StatusOr<SensorImages> {
    ASSIGN_OR_RETURN(SensorImages images, read(frame));
    if (name == "late" || name == "depth_late") {
      const auto late = static_cast<size_t>(amount);
      ASSIGN_OR_RETURN(const SensorImages earlier, read(frame - std::min(frame, late)));
      (name == "late" ? images.right : images.depth) =
          name == "late" ? earlier.right : earlier.depth;
      return images;
    }
    const auto edit = Edits().find(name);
    if (edit == Edits().end()) return absl::InvalidArgumentError(absl::StrCat("no damage ", name));
    edit->second(images, amount);
    return images;
  };
}

}  // namespace corbslam::client_agent

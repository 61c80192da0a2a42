#include "client_agent/live/openni2/openni_picture.h"

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {
namespace {

using openni::VideoMode;

bool IsUsable(openni::SensorType type, openni::PixelFormat format) {
  if (type == openni::SENSOR_DEPTH) {
    return format == openni::PIXEL_FORMAT_DEPTH_1_MM || format == openni::PIXEL_FORMAT_DEPTH_100_UM;
  }
  return format == openni::PIXEL_FORMAT_RGB888 || format == openni::PIXEL_FORMAT_GRAY8 ||
         format == openni::PIXEL_FORMAT_YUV422 || format == openni::PIXEL_FORMAT_YUYV;
}

}  // namespace

std::string DescribeMode(const VideoMode& mode) {
  return absl::StrCat(mode.getResolutionX(), "x", mode.getResolutionY(), " at ", mode.getFps(),
                      "/s, format ", static_cast<int>(mode.getPixelFormat()));
}

std::string ListModes(const openni::SensorInfo& sensor) {
  std::string text;
  const auto& modes = sensor.getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) {
    absl::StrAppend(&text, i == 0 ? "" : "; ", DescribeMode(modes[i]));
  }
  return text;
}

const VideoMode* ChooseMode(const openni::SensorInfo& sensor, const cv::Size& size,
                            std::optional<double> rate_hz) {
  const VideoMode* best = nullptr;
  const auto cost = [&](const VideoMode& mode) {
    return rate_hz.has_value() ? std::abs(mode.getFps() - *rate_hz) : -mode.getFps();
  };
  const auto& modes = sensor.getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) {
    const VideoMode& mode = modes[i];
    if (mode.getResolutionX() != size.width || mode.getResolutionY() != size.height) continue;
    if (!IsUsable(sensor.getSensorType(), mode.getPixelFormat())) continue;
    if (best == nullptr || cost(mode) < cost(*best)) best = &mode;
  }
  return best;
}

cv::Mat ToGrey(const openni::VideoFrameRef& frame) {
  const auto stride = static_cast<size_t>(frame.getStrideInBytes());
  auto* const data = const_cast<void*>(frame.getData());  // It is only read.
  const cv::Size size(frame.getWidth(), frame.getHeight());
  cv::Mat grey;
  switch (frame.getVideoMode().getPixelFormat()) {
    case openni::PIXEL_FORMAT_GRAY8:
      return cv::Mat(size, CV_8UC1, data, stride).clone();
    case openni::PIXEL_FORMAT_RGB888:
      cv::cvtColor(cv::Mat(size, CV_8UC3, data, stride), grey, cv::COLOR_RGB2GRAY);
      break;
    case openni::PIXEL_FORMAT_YUV422:
      cv::cvtColor(cv::Mat(size, CV_8UC2, data, stride), grey, cv::COLOR_YUV2GRAY_UYVY);
      break;
    case openni::PIXEL_FORMAT_YUYV:
      cv::cvtColor(cv::Mat(size, CV_8UC2, data, stride), grey, cv::COLOR_YUV2GRAY_YUYV);
      break;
    default:
      break;  // SetUp lets no other in.
  }
  return grey;
}

cv::Mat ToDepth(const openni::VideoFrameRef& frame) {
  return cv::Mat(frame.getHeight(), frame.getWidth(), CV_16UC1, const_cast<void*>(frame.getData()),
                 static_cast<size_t>(frame.getStrideInBytes()))
      .clone();
}

}  // namespace corbslam::client_agent

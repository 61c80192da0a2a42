// A long wall of random grey along which a stereo camera drives, for tests of whole agents.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_TESTING_DRIVEN_WALL_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_TESTING_DRIVEN_WALL_H_

#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

constexpr int kWallPictureWidth_px = 640;
constexpr int kWallPictureHeight_px = 480;
constexpr double kWallFocal_px = 400;
constexpr double kWallBaseline_m = 0.2;
constexpr double kWall_m = 4;  // How far away it is.
// What a pixel of the wall measures.
constexpr double kWallPixel_m = kWall_m / kWallFocal_px;

inline StereoCalibration WallCalibration() {
  StereoCalibration stereo;
  stereo.camera = {.fx_px = kWallFocal_px,
                   .fy_px = kWallFocal_px,
                   .cx_px = 320,
                   .cy_px = 240,
                   .width_px = kWallPictureWidth_px,
                   .height_px = kWallPictureHeight_px,
                   .baseline_m = kWallBaseline_m,
                   .close_depth_m = 8};
  return stereo;
}

// A wall along which the camera can drive so many pixels.
inline cv::Mat LongWall(int seed, int driven_px) {
  cv::RNG random(static_cast<uint64_t>(seed));
  cv::Mat coarse(kWallPictureHeight_px / 4, (kWallPictureWidth_px + driven_px + 100) / 4, CV_8UC1);
  random.fill(coarse, cv::RNG::UNIFORM, 0, 256);
  cv::Mat wall;
  cv::resize(coarse, wall, cv::Size(), 4, 4, cv::INTER_CUBIC);
  return wall;
}

// What the camera sees after it drove `x_px` along the wall.
inline SensorImages SeeWall(const cv::Mat& wall, int x_px, int64_t timestamp_ns) {
  const int disparity_px = static_cast<int>(kWallFocal_px * kWallBaseline_m / kWall_m);
  const auto part = [&](int x) {
    return wall(cv::Rect(x, 0, kWallPictureWidth_px, kWallPictureHeight_px)).clone();
  };
  return {.timestamp_ns = timestamp_ns, .grey = part(x_px), .right = part(x_px + disparity_px)};
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_TESTING_DRIVEN_WALL_H_

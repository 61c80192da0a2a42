// What calibration tools write, and how tests hand it to the converter. For tests only.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_CONVERT_TEST_FILES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_CONVERT_TEST_FILES_H_

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "client_agent/source/rig/convert/rig_convert.h"

namespace corbslam::client_agent {

inline constexpr char kKalibr[] = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [0.0034, 0.0007, -0.0021, 0.0002]
  distortion_model: equidistant
  intrinsics: [190.9, 190.8, 254.9, 256.9]
  resolution: [512, 512]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: 0.004
  T_cam_imu:
  - [0.0, -1.0, 0.0, 0.05]
  - [1.0, 0.0, 0.0, -0.02]
  - [0.0, 0.0, 1.0, 0.01]
  - [0.0, 0.0, 0.0, 1.0]
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.101]
  - [0.0, 1.0, 0.0, 0.0002]
  - [0.0, 0.0, 1.0, 0.0003]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: ds
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [-0.2, 0.59, 158.1, 158.2, 252.4, 255.0]
  resolution: [512, 512]
  timeshift_cam_imu: 0.0
)";

inline constexpr char kRosLeft[] = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [430.1, 0, 310.5, 0, 431.2, 240.7, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.36, 0.1, 0.001, -0.002, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [400, 0, 320, 0, 0, 400, 240, 0, 0, 0, 1, 0]}
)";

inline constexpr char kOpenCv[] = R"(%YAML:1.0
---
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 530., 0., 340., 0., 531., 230., 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 14
   dt: d
   data: [ -0.27, -0.05, 0., 0., 0.24, 0., 0., 0.01, 0., 0., 0., 0., 0., 0. ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 532., 0., 330., 0., 533., 234., 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.28, 0.08, 0., 0., 0. ]
)";
inline constexpr char kOpenCvPair[] = R"(%YAML:1.0
---
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.083, 0.0011, -0.0007 ]
)";

inline constexpr char kOrb2Rgbd[] = R"(%YAML:1.0
Camera.fx: 517.3
Camera.fy: 516.5
Camera.cx: 318.6
Camera.cy: 255.3
Camera.k1: 0.26
Camera.k2: -0.95
Camera.p1: -0.005
Camera.p2: 0.002
Camera.k3: 1.16
Camera.width: 640
Camera.height: 480
Camera.fps: 30.0
Camera.bf: 40.0
DepthMapFactor: 5000.0
)";

inline constexpr char kOrb3[] = R"(%YAML:1.0
File.version: "1.0"
Camera.type: "KannalaBrandt8"
Camera1.fx: 190.9
Camera1.fy: 190.8
Camera1.cx: 254.9
Camera1.cy: 256.8
Camera1.k1: 0.0034
Camera1.k2: 0.0007
Camera1.k3: -0.002
Camera1.k4: 0.0002
Camera2.fx: 190.4
Camera2.fy: 190.4
Camera2.cx: 252.5
Camera2.cy: 255.0
Camera2.k1: 0.0034
Camera2.k2: 0.0017
Camera2.k3: -0.003
Camera2.k4: 0.0003
Stereo.T_c1_c2: !!opencv-matrix
  rows: 4
  cols: 4
  dt: f
  data: [1, 0, 0, 0.101, 0, 1, 0, 0.002, 0, 0, 1, 0.001, 0, 0, 0, 1]
Camera.width: 512
Camera.height: 512
Camera.fps: 20
IMU.T_b_c1: !!opencv-matrix
  rows: 4
  cols: 4
  dt: f
  data: [0, -1, 0, 0.04, 1, 0, 0, 0.05, 0, 0, 1, 0.06, 0, 0, 0, 1]
)";

inline std::string WriteText(const std::string& name, const std::string& text) {
  const std::string path = ::testing::TempDir() + "/" + name;
  std::ofstream(path) << text;
  return path;
}

inline RigFiles One(const std::string& name, const std::string& text) {
  return {.paths = {WriteText(name, text)}, .format = "", .size = {}, .trust = false};
}

inline RigFiles OpenCvFiles(const std::string& intrinsics, const std::string& extrinsics) {
  return {
      .paths = {WriteText("intrinsics.yml", intrinsics), WriteText("extrinsics.yml", extrinsics)},
      .format = "",
      .size = PictureSize{640, 480},
      .trust = false};
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_CONVERT_CONVERT_TEST_FILES_H_

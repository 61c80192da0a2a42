// Calibrations of other systems: read, or refused by their names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>

#include "absl/strings/str_replace.h"
#include "client_agent/source/rig/convert/convert_test_files.h"
#include "client_agent/source/rig/convert/rig_convert.h"

namespace corbslam::client_agent {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr char kBasalt[] = R"({"value0": {
  "T_imu_cam": [
    {"px": 0.01, "py": 0.02, "pz": 0.03, "qx": 0, "qy": 0, "qz": 0.7071067811865476, "qw": 0.7071067811865476},
    {"px": 0.01, "py": 0.12, "pz": 0.03, "qx": 0, "qy": 0, "qz": 0.7071067811865476, "qw": 0.7071067811865476}],
  "intrinsics": [
    {"camera_type": "ds", "intrinsics": {"fx": 349.7, "fy": 349.8, "cx": 365.9, "cy": 249.2, "xi": -0.27, "alpha": 0.566}},
    {"camera_type": "kb4", "intrinsics": {"fx": 361.6, "fy": 361.7, "cx": 379.4, "cy": 255.3, "k1": 0.01, "k2": 0.02, "k3": 0.03, "k4": 0.04}}],
  "resolution": [[752, 480], [752, 480]]}})";

TEST(OtherSystemsTest, ReadsBasalt) {
  const auto converted = ConvertRig(One("basalt.json", kBasalt));
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "basalt");
  const Rig& rig = converted->rig;
  EXPECT_EQ(rig.cameras[0].raw.fy_px, 349.8);
  EXPECT_EQ(rig.cameras[0].width_px, 752);
  EXPECT_EQ(std::get<DoubleSphere>(rig.cameras[0].raw.lens).xi, -0.27);
  EXPECT_EQ(std::get<DoubleSphere>(rig.cameras[0].raw.lens).alpha, 0.566);
  EXPECT_EQ(std::get<Equidistant>(rig.cameras[1].raw.lens).k4, 0.04);
  // The IMU's y axis is the cameras' x axis, along which the right one stands.
  EXPECT_LT((rig.right_from_left.translation - Eigen::Vector3d(-0.1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((rig.body_from_camera->translation - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 1e-12);
}

TEST(OtherSystemsTest, RefusesBasaltsOtherModels) {
  const std::string eucm = absl::StrReplaceAll(kBasalt, {{"\"ds\"", "\"eucm\""}});
  EXPECT_THAT(std::string(ConvertRig(One("basalt.json", eucm)).status().message()),
              AllOf(HasSubstr("camera_type is 'eucm'"), HasSubstr("basalt_calibrate")));
  const std::string turned =
      absl::StrReplaceAll(kBasalt, {{"\"qw\": 0.7071067811865476},", "\"qw\": 1},"}});
  EXPECT_THAT(std::string(ConvertRig(One("basalt.json", turned)).status().message()),
              HasSubstr("must be 1"));
}

constexpr char kSvo[] = R"(label: rig
cameras:
- camera:
    distortion:
      parameters: {cols: 1, rows: 4, data: [-0.2917, 0.0823, 5.3e-05, -0.00018]}
      type: radial-tangential
    image_height: 480
    image_width: 640
    intrinsics: {cols: 1, rows: 4, data: [536.7, 536.4, 330.7, 249.5]}
    type: pinhole
  T_B_C: {cols: 4, rows: 4, data: [1,0,0,0.02, 0,1,0,0, 0,0,1,0, 0,0,0,1]}
- camera:
    distortion:
      parameters: {cols: 1, rows: 4, data: [0.01, 0.02, 0.03, 0.04]}
      type: equidistant
    image_height: 480
    image_width: 640
    intrinsics: {cols: 1, rows: 4, data: [537.1, 537.2, 331.1, 248.9]}
    type: pinhole
  T_B_C: {cols: 4, rows: 4, data: [1,0,0,0.14, 0,1,0,0.001, 0,0,1,0, 0,0,0,1]}
)";

TEST(OtherSystemsTest, ReadsSvo) {
  const auto converted = ConvertRig(One("svo.yaml", kSvo));
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "svo");
  const Rig& rig = converted->rig;
  EXPECT_EQ(std::get<RadialTangential>(rig.cameras[0].raw.lens).p2, -0.00018);
  EXPECT_EQ(std::get<Equidistant>(rig.cameras[1].raw.lens).k2, 0.02);
  EXPECT_EQ(rig.cameras[1].raw.cx_px, 331.1);
  EXPECT_EQ(rig.cameras[1].height_px, 480);
  EXPECT_LT((rig.right_from_left.translation - Eigen::Vector3d(-0.12, -0.001, 0)).norm(), 1e-12);
  EXPECT_EQ(rig.body_from_camera->translation.x(), 0.02);
}

constexpr char kOkvis[] = R"(%YAML:1.0
cameras:
     - {T_SC:
        [ 1.0, 0.0, 0.0, -0.02,
          0.0, 1.0, 0.0, 0.0,
          0.0, 0.0, 1.0, 0.0,
          0.0, 0.0, 0.0, 1.0],
        image_dimension: [752, 480],
        distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05],
        distortion_type: radialtangential,
        focal_length: [458.6, 457.3],
        principal_point: [367.2, 248.4]}
     - {T_SC:
        [ 1.0, 0.0, 0.0, 0.09,
          0.0, 1.0, 0.0, 0.0,
          0.0, 0.0, 1.0, 0.0,
          0.0, 0.0, 0.0, 1.0],
        image_dimension: [752, 480],
        distortion_coefficients: [-0.29, 0.08, -0.0002, -2.2e-05],
        distortion_type: radialtangential,
        focal_length: [457.6, 456.1],
        principal_point: [379.9, 255.2]}
)";

TEST(OtherSystemsTest, ReadsOkvis2) {
  const auto converted = ConvertRig(One("okvis2.yaml", kOkvis));
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "okvis2");
  const Rig& rig = converted->rig;
  EXPECT_EQ(std::get<RadialTangential>(rig.cameras[0].raw.lens).k1, -0.28);
  EXPECT_EQ(rig.cameras[1].raw.fx_px, 457.6);
  EXPECT_EQ(rig.cameras[1].raw.cy_px, 255.2);
  EXPECT_NEAR(rig.right_from_left.translation.x(), -0.11, 1e-12);
  const std::string okvis = kOkvis;
  const auto one = ConvertRig(One("okvis2.yaml", okvis.substr(0, okvis.rfind("     - {T_SC"))));
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->rig.kind, RigKind::kMonocular);
  EXPECT_THAT(one->notes, Contains(HasSubstr("no metres")));
}

constexpr char kStella[] = R"(Camera:
  name: "EuRoC"
  setup: "stereo"
  model: "perspective"
  fx: 435.2
  fy: 435.25
  cx: 367.5
  cy: 252.2
  k1: 0.0
  fps: 20.0
  cols: 752
  rows: 480
  focal_x_baseline: 47.872
)";

TEST(OtherSystemsTest, ReadsStellaVslam) {
  const auto rectified = ConvertRig(One("stella.yaml", kStella));
  ASSERT_TRUE(rectified.ok()) << rectified.status();
  EXPECT_EQ(rectified->format, "stella_vslam");
  EXPECT_TRUE(rectified->rig.rectified);
  EXPECT_NEAR(rectified->rig.baseline_m, 0.11, 1e-12);
  EXPECT_EQ(rectified->rig.rate_hz, 20);
  const auto raw = ConvertRig(One("stella.yaml", std::string(kStella) + R"(StereoRectifier:
  model: "perspective"
  K_left: [458.6, 0, 367.2, 0, 457.3, 248.4, 0, 0, 1]
  D_left: [-0.28, 0.07, 0.0002, 1.7e-05, 0]
  R_left: [1, 0, 0, 0, 1, 0, 0, 0, 1]
  K_right: [457.6, 0, 379.9, 0, 456.1, 255.2, 0, 0, 1]
  D_right: [-0.29, 0.08, -0.0002, -2.2e-05, 0]
  R_right: [1, 0, 0, 0, 1, 0, 0, 0, 1]
)"));
  ASSERT_TRUE(raw.ok()) << raw.status();
  EXPECT_FALSE(raw->rig.rectified);
  EXPECT_EQ(raw->rig.cameras[1].raw.cx_px, 379.9);
  EXPECT_NEAR(raw->rig.right_from_left.translation.x(), -0.11, 1e-12);
  const std::string rgbd = absl::StrReplaceAll(kStella, {{"\"stereo\"", "\"RGBD\""}}) +
                           "Preprocessing:\n  depthmap_factor: 5000\n";
  const auto depth = ConvertRig(One("stella.yaml", rgbd));
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_EQ(depth->rig.depth.units_per_m, 5000);
  const std::string mono = absl::StrReplaceAll(kStella, {{"\"stereo\"", "\"monocular\""}});
  const auto one = ConvertRig(One("stella.yaml", mono));
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->rig.kind, RigKind::kMonocular);
  EXPECT_THAT(one->notes, Contains(HasSubstr("no metres")));
}

TEST(OtherSystemsTest, ReadsVinsFusion) {
  WriteText("cam0_mei.yaml", R"(%YAML:1.0
---
model_type: MEI
camera_name: camera
image_width: 752
image_height: 480
mirror_parameters:
   xi: 1.89
distortion_parameters:
   k1: -0.1
   k2: 0.3
   p1: 0.001
   p2: -0.002
projection_parameters:
   gamma1: 833.0
   gamma2: 834.0
   u0: 370.6
   v0: 246.1
)");
  WriteText("cam1_kb.yaml", R"(%YAML:1.0
---
model_type: KANNALA_BRANDT
camera_name: camera
image_width: 752
image_height: 480
projection_parameters:
   k2: 0.01
   k3: 0.02
   k4: 0.03
   k5: 0.04
   mu: 461.0
   mv: 460.0
   u0: 375.1
   v0: 241.9
)");
  const std::string main = R"(%YAML:1.0
num_of_cam: 2
cam0_calib: "cam0_mei.yaml"
cam1_calib: "cam1_kb.yaml"
image_width: 752
image_height: 480
body_T_cam0: !!opencv-matrix
   rows: 4
   cols: 4
   dt: d
   data: [1, 0, 0, -0.02, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
body_T_cam1: !!opencv-matrix
   rows: 4
   cols: 4
   dt: d
   data: [1, 0, 0, 0.09, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
)";
  const auto converted = ConvertRig(One("vins.yaml", main));
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "vins_fusion");
  const Rig& rig = converted->rig;
  EXPECT_EQ(std::get<UnifiedSphere>(rig.cameras[0].raw.lens).xi, 1.89);
  EXPECT_EQ(std::get<UnifiedSphere>(rig.cameras[0].raw.lens).distortion.p2, -0.002);
  EXPECT_EQ(rig.cameras[0].raw.fy_px, 834);
  EXPECT_EQ(std::get<Equidistant>(rig.cameras[1].raw.lens).k1, 0.01);
  EXPECT_EQ(rig.cameras[1].raw.fx_px, 461);
  EXPECT_NEAR(rig.right_from_left.translation.x(), -0.11, 1e-12);
  const std::string lost = absl::StrReplaceAll(main, {{"cam1_kb", "cam1_lost"}});
  EXPECT_THAT(std::string(ConvertRig(One("vins.yaml", lost)).status().message()),
              HasSubstr("cam1_lost.yaml"));
  RigFiles one = {
      .paths = {::testing::TempDir() + "/cam0_mei.yaml"}, .format = "", .size = {}, .trust = false};
  EXPECT_THAT(std::string(ConvertRig(one).status().message()),
              HasSubstr("is one camera's file of VINS-Fusion's"));
}

TEST(OtherSystemsTest, RefusesOthersByTheirNames) {
  const struct {
    const char* file;
    const char* text;
    const char* says;
  } cases[] = {
      {"SN1234.conf", "[LEFT_CAM_HD]\nfx=700.8\nfy=700.8\n[STEREO]\nBaseline=119.9\n", "a ZED's"},
      {"realsense.txt", " Intrinsic of \"Depth\" / 640x480 / {Z16}\n  Width: 640\n", "RealSense"},
      {"oak.json", "{\"boardName\": \"OAK-D\", \"cameraData\": [[0, {}]]}", "an OAK's (DepthAI's)"},
      {"cameras.txt",
       "# Camera list with one line of data per camera:\n1 PINHOLE 640 480 1 1 1 1\n", "COLMAP's"}};
  for (const auto& [file, text, says] : cases) {
    const absl::Status status = ConvertRig(One(file, text)).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << file << status;
    EXPECT_THAT(std::string(status.message()),
                AllOf(HasSubstr(file), HasSubstr(says), HasSubstr("docs/rig.md")));
  }
}

}  // namespace
}  // namespace corbslam::client_agent

#include "client_agent/source/rig/convert/rig_convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/camera/pair_geometry.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr char kKalibr[] = R"(cam0:
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

constexpr char kRosLeft[] = R"(image_width: 640
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

constexpr char kOpenCv[] = R"(%YAML:1.0
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
constexpr char kOpenCvPair[] = R"(%YAML:1.0
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

constexpr char kOrb2Rgbd[] = R"(%YAML:1.0
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

constexpr char kOrb3[] = R"(%YAML:1.0
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

std::string WriteText(const std::string& name, const std::string& text) {
  const std::string path = ::testing::TempDir() + "/" + name;
  std::ofstream(path) << text;
  return path;
}

RigFiles One(const std::string& name, const std::string& text) {
  return {.paths = {WriteText(name, text)}, .format = "", .size = {}, .trust = false};
}

TEST(RigConvertTest, ReadsKalibr) {
  const auto converted = ConvertRig(One("camchain.yaml", kKalibr));
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "kalibr");
  const Rig& rig = converted->rig;
  EXPECT_EQ(std::get<Equidistant>(rig.cameras[0].raw.lens).k3, -0.0021);
  EXPECT_EQ(rig.cameras[0].raw.cy_px, 256.9);
  EXPECT_EQ(std::get<DoubleSphere>(rig.cameras[1].raw.lens).alpha, 0.59);
  EXPECT_EQ(rig.cameras[1].raw.fy_px, 158.2);
  EXPECT_EQ(rig.right_from_left.translation, Eigen::Vector3d(-0.101, 0.0002, 0.0003));
  // The camera's centre in the IMU's frame.
  EXPECT_LT((rig.body_from_camera->translation - Eigen::Vector3d(0.02, 0.05, -0.01)).norm(), 1e-12);
  ASSERT_FALSE(converted->notes.empty());
  EXPECT_THAT(converted->notes[0], HasSubstr("cam0.timeshift_cam_imu of 0.004 s"));
  // cam1 has the IMU's own times.
  EXPECT_EQ(SecondTimeOffset_ns(rig), -4'000'000);
}

TEST(RigConvertTest, ReadsKalibrsOmni) {
  const std::string omni = absl::StrReplaceAll(
      kKalibr, {{"camera_model: ds", "camera_model: omni"},
                {"distortion_coeffs: []", "distortion_coeffs: [-0.1, 0.02, 0.0004, -0.0003]"},
                {"distortion_model: none", "distortion_model: radtan"},
                {"[-0.2, 0.59, 158.1, 158.2", "[1.2, 358.1, 358.2"}});
  const auto converted = ConvertRig(One("camchain.yaml", omni));
  ASSERT_TRUE(converted.ok()) << converted.status();
  const auto& lens = std::get<UnifiedSphere>(converted->rig.cameras[1].raw.lens);
  EXPECT_EQ(lens.xi, 1.2);
  EXPECT_EQ(lens.distortion.k2, 0.02);
  EXPECT_EQ(converted->rig.cameras[1].raw.fx_px, 358.1);
}

// A pair of which R and P are those of its own rectification.
TEST(RigConvertTest, ReadsRosCameraInfo) {
  Rigid3d right_from_left;
  right_from_left.rotation = Eigen::AngleAxisd(0.03, Eigen::Vector3d(1, -2, 0.5).normalized());
  right_from_left.translation = {-0.12, 0.002, 0.004};
  const PairRotations rotations = RotationsOf(right_from_left);
  const auto rows = [](const Eigen::Quaterniond& rotation) {
    const Eigen::Matrix3d m = rotation.toRotationMatrix();
    std::string text;
    for (int i = 0; i < 9; ++i) absl::StrAppend(&text, i == 0 ? "" : ", ", m(i / 3, i % 3));
    return text;
  };
  const std::string identity = "1, 0, 0, 0, 1, 0, 0, 0, 1";
  const double shift = -400 * right_from_left.translation.norm();
  const std::string left = absl::StrReplaceAll(
      kRosLeft, {{"data: [" + identity, "data: [" + rows(rotations.rectified_from_left)}});
  const std::string right = absl::StrReplaceAll(
      kRosLeft, {{"data: [" + identity, "data: [" + rows(rotations.rectified_from_right)},
                 {"400, 0, 320, 0,", absl::StrCat("400, 0, 320, ", shift, ",")}});
  const RigFiles files = {.paths = {WriteText("left.yaml", left), WriteText("right.yaml", right)},
                          .format = "",
                          .size = {},
                          .trust = false};
  const auto converted = ConvertRig(files);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "ros");
  const Rigid3d& found = converted->rig.right_from_left;
  EXPECT_LT(found.rotation.angularDistance(right_from_left.rotation), 1e-4);
  EXPECT_LT((found.translation - right_from_left.translation).norm(), 1e-5);
  EXPECT_EQ(converted->rig.cameras[0].raw.fx_px, 430.1);

  const RigFiles exchanged = {
      .paths = {files.paths[1], files.paths[0]}, .format = "", .size = {}, .trust = false};
  EXPECT_THAT(std::string(ConvertRig(exchanged).status().message()), HasSubstr("exchanged"));
}

TEST(RigConvertTest, ReadsOpenCvsTwoFiles) {
  RigFiles files = {
      .paths = {WriteText("intrinsics.yml", kOpenCv), WriteText("extrinsics.yml", kOpenCvPair)},
      .format = "",
      .size = {},
      .trust = false};
  EXPECT_THAT(std::string(ConvertRig(files).status().message()), HasSubstr("--size"));
  files.size = {640, 480};
  const auto converted = ConvertRig(files);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "opencv");
  const auto& lens = std::get<RadialTangential>(converted->rig.cameras[0].raw.lens);
  EXPECT_EQ(lens.k3, 0.24);
  EXPECT_EQ(lens.k6, 0.01);
  EXPECT_EQ(converted->rig.right_from_left.translation.x(), -0.083);
}

TEST(RigConvertTest, ABaselineInMillimetresIsRefused) {
  RigFiles files = {
      .paths = {WriteText("intrinsics.yml", kOpenCv),
                WriteText("extrinsics.yml", absl::StrReplaceAll(kOpenCvPair, {{"-0.083", "-83"}}))},
      .format = "",
      .size = PictureSize{640, 480},
      .trust = false};
  EXPECT_THAT(std::string(ConvertRig(files).status().message()), HasSubstr("is it in metres?"));
}

TEST(RigConvertTest, ReadsOrbSlam2) {
  const auto rgbd = ConvertRig(One("TUM1.yaml", kOrb2Rgbd));
  ASSERT_TRUE(rgbd.ok()) << rgbd.status();
  EXPECT_EQ(rgbd->rig.kind, RigKind::kRgbd);
  EXPECT_EQ(rgbd->rig.depth.units_per_m, 5000);
  EXPECT_EQ(std::get<RadialTangential>(rgbd->rig.cameras[0].raw.lens).k3, 1.16);
  EXPECT_EQ(rgbd->rig.rate_hz, 30);

  const std::string stereo = absl::StrReplaceAll(kOrb2Rgbd, {{"DepthMapFactor: 5000.0\n", ""},
                                                             {"k1: 0.26", "k1: 0"},
                                                             {"k2: -0.95", "k2: 0"},
                                                             {"p1: -0.005", "p1: 0"},
                                                             {"p2: 0.002", "p2: 0"},
                                                             {"k3: 1.16", "k3: 0"},
                                                             {"516.5", "517.3"}});
  const auto rectified = ConvertRig(One("KITTI.yaml", stereo));
  ASSERT_TRUE(rectified.ok()) << rectified.status();
  EXPECT_TRUE(rectified->rig.rectified);
  EXPECT_NEAR(rectified->rig.baseline_m, 40 / 517.3, 1e-12);

  const std::string mono = absl::StrReplaceAll(stereo, {{"Camera.bf: 40.0\n", ""}});
  EXPECT_THAT(std::string(ConvertRig(One("mono.yaml", mono)).status().message()),
              HasSubstr("no scale"));
}

TEST(RigConvertTest, ReadsOrbSlam3) {
  const auto converted = ConvertRig(One("TUM-VI.yaml", kOrb3));
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "orbslam");
  const Rig& rig = converted->rig;
  EXPECT_EQ(std::get<Equidistant>(rig.cameras[1].raw.lens).k2, 0.0017);
  EXPECT_EQ(rig.right_from_left.translation, Eigen::Vector3d(-0.101, -0.002, -0.001));
  EXPECT_EQ(rig.body_from_camera->translation, Eigen::Vector3d(0.04, 0.05, 0.06));
}

TEST(RigConvertTest, ReadsKitti) {
  RigFiles files = One("calib.txt",
                       "P0: 718 0 607 0 0 718 185 0 0 0 1 0\n"
                       "P1: 718 0 607 -386.14 0 718 185 0 0 0 1 0\n");
  EXPECT_THAT(std::string(ConvertRig(files).status().message()), HasSubstr("--size"));
  files.size = {1241, 376};
  const auto odometry = ConvertRig(files);
  ASSERT_TRUE(odometry.ok()) << odometry.status();
  EXPECT_TRUE(odometry->rig.rectified);
  EXPECT_NEAR(odometry->rig.baseline_m, 386.14 / 718, 1e-9);
  // As the layout's own calibration has it.
  EXPECT_NEAR(*odometry->rig.close_depth_m, 35 * 386.14 / 718, 1e-9);

  const auto raw = ConvertRig(One("calib_cam_to_cam.txt",
                                  "calib_time: 09-Jan-2012 13:57:47\n"
                                  "S_rect_00: 1.242000e+03 3.750000e+02\n"
                                  "P_rect_00: 721 0 609 0 0 721 172 0 0 0 1 0\n"
                                  "P_rect_01: 721 0 609 -387.5 0 721 172 0 0 0 1 0\n"));
  ASSERT_TRUE(raw.ok()) << raw.status();
  EXPECT_EQ(raw->rig.cameras[1].width_px, 1242);
}

TEST(RigConvertTest, ReadsEuroc) {
  const auto camera = [](const char* x) {
    return absl::StrCat("T_BS:\n  rows: 4\n  cols: 4\n  data: [1, 0, 0, ", x,
                        ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [752, 480]\n"
                        "camera_model: pinhole\nintrinsics: [458, 457, 367, 248]\n"
                        "distortion_model: radial-tangential\n"
                        "distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]\n");
  };
  RigFiles files = One("sensor0.yaml", camera("0"));
  files.paths.push_back(WriteText("sensor1.yaml", camera("0.11")));
  const auto converted = ConvertRig(files);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->format, "euroc");
  EXPECT_NEAR(converted->rig.right_from_left.translation.x(), -0.11, 1e-12);
  EXPECT_NEAR(*converted->rig.close_depth_m, 5.5, 1e-9);
}

// What `rostopic echo` and `ros2 topic echo` print.
TEST(RigConvertTest, ReadsRosMessages) {
  const std::string left =
      "header:\n  seq: 1\nheight: 376\nwidth: 1241\ndistortion_model: \"plumb_bob\"\n"
      "D: [0, 0, 0, 0, 0]\nK: [718.8, 0, 607.1, 0, 718.8, 185.2, 0, 0, 1]\n"
      "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nP: [718.8, 0, 607.1, 0, 0, 718.8, 185.2, 0, 0, 0, 1, 0]\n"
      "binning_x: 0\nroi:\n  x_offset: 0\n  y_offset: 0\n---\n";
  const std::string right = absl::StrReplaceAll(left, {{"607.1, 0, 0,", "607.1, -359.4, 0,"}});
  const auto convert = [](const std::string& a, const std::string& b) {
    RigFiles files = One("echo_left.yaml", a);
    files.paths.push_back(WriteText("echo_right.yaml", b));
    return ConvertRig(files);
  };
  const auto lower = [](const std::string& text) {
    return absl::StrReplaceAll(text, {{"\nD:", "\nd:"}, {"K:", "k:"}, {"R:", "r:"}, {"P:", "p:"}});
  };
  for (const auto& converted : {convert(left, right), convert(lower(left), lower(right))}) {
    ASSERT_TRUE(converted.ok()) << converted.status();
    EXPECT_EQ(converted->format, "ros");
    EXPECT_EQ(converted->rig.cameras[0].width_px, 1241);
    EXPECT_NEAR(converted->rig.right_from_left.translation.x(), -359.4 / 718.8, 1e-12);
  }
  const auto says = [&](const char* from, const char* to) {
    const std::string bad = absl::StrReplaceAll(left, {{from, to}});
    return std::string(convert(bad, right).status().message());
  };
  EXPECT_THAT(says("binning_x: 0", "binning_x: 2"), HasSubstr("binning_x is 2"));
  EXPECT_THAT(says("x_offset: 0", "x_offset: 8"), HasSubstr("roi.x_offset is 8"));
  EXPECT_THAT(says("K: [718.8, 0,", "K: [718.8, 3,"), HasSubstr("K has a skew of 3 px"));
  EXPECT_THAT(says("width: 1241", "width: 1241.5"), HasSubstr("must be a whole number"));
}

RigFiles OpenCvFiles(const std::string& intrinsics, const std::string& extrinsics) {
  return {
      .paths = {WriteText("intrinsics.yml", intrinsics), WriteText("extrinsics.yml", extrinsics)},
      .format = "",
      .size = PictureSize{640, 480},
      .trust = false};
}

TEST(RigConvertTest, OpenCvsFourNumbersNeedTheirLens) {
  const std::string four =
      absl::StrReplaceAll(kOpenCv, {{"0.24, 0., 0., 0.01, 0., 0., 0., 0., 0., 0. ]", "]"},
                                    {"-0.28, 0.08, 0., 0., 0. ]", "-0.28, 0.08, 0.01, 0.002 ]"}});
  RigFiles files = OpenCvFiles(absl::StrReplaceAll(four, {{"0., 0., ]", "0., 0. ]"}}), kOpenCvPair);
  EXPECT_THAT(std::string(ConvertRig(files).status().message()),
              HasSubstr("D1 has 4 numbers: of cv::fisheye"));
  files.lens = "equidistant";
  auto converted = ConvertRig(files);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(std::get<Equidistant>(converted->rig.cameras[1].raw.lens).k4, 0.002);
  files.lens = "radial-tangential";
  converted = ConvertRig(files);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(std::get<RadialTangential>(converted->rig.cameras[1].raw.lens).p2, 0.002);
  files.lens = "wide";
  EXPECT_THAT(std::string(ConvertRig(files).status().message()), HasSubstr("--lens is 'wide'"));
  RigFiles kalibr = One("camchain.yaml", kKalibr);
  kalibr.lens = "equidistant";
  EXPECT_THAT(std::string(ConvertRig(kalibr).status().message()),
              HasSubstr("--lens is of OpenCV's files"));
}

TEST(RigConvertTest, OpenCvsFilesMustAgree) {
  const std::string m1 =
      "M1: {rows: 3, cols: 3, dt: d, data: [530, 0, 341, 0, 531, 230, 0, 0, 1]}\n";
  EXPECT_THAT(std::string(ConvertRig(OpenCvFiles(kOpenCv, kOpenCvPair + m1)).status().message()),
              HasSubstr("M1 differs in"));
  const std::string skewed = absl::StrReplaceAll(kOpenCv, {{"530., 0.,", "530., 0.6,"}});
  EXPECT_THAT(std::string(ConvertRig(OpenCvFiles(skewed, kOpenCvPair)).status().message()),
              HasSubstr("M1 has a skew of 0.6 px"));
  const std::string turned = absl::StrReplaceAll(kOpenCvPair, {{"-0.083", "0.083"}});
  EXPECT_THAT(std::string(ConvertRig(OpenCvFiles(kOpenCv, turned)).status().message()),
              HasSubstr("exchanged, or is the motion inverted?"));
}

// ORB-SLAM2's own file has values that begin right behind the colon.
TEST(RigConvertTest, ReadsOpenCvsYamlWithoutBlanks) {
  const std::string crowded =
      absl::StrReplaceAll(kOrb2Rgbd, {{"Camera.fps: 30.0", "Camera.fps:30.0\nViewer.Size:2"}});
  const auto converted = ConvertRig(One("TUM1.yaml", crowded));
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(converted->rig.rate_hz, 30);
  const auto pair =
      ConvertRig(OpenCvFiles(absl::StrReplaceAll(kOpenCv, {{"data: [", "data:["}}), kOpenCvPair));
  ASSERT_TRUE(pair.ok()) << pair.status();
  EXPECT_EQ(pair->rig.cameras[1].raw.cy_px, 234);
}

TEST(RigConvertTest, SaysWhatItCannotKnowOfOrbSlam) {
  const std::string old = absl::StrReplaceAll(
      kOrb2Rgbd, {{"DepthMapFactor: 5000.0", "Camera.type: KannalaBrandt8\nTlr: [1, 0]"}});
  EXPECT_THAT(std::string(ConvertRig(One("old.yaml", old)).status().message()),
              HasSubstr("Tlr is of ORB-SLAM3's older settings, whose format is not known"));
  const auto smaller = ConvertRig(One("new.yaml", std::string(kOrb3) + "Camera.newWidth: 256\n"));
  ASSERT_TRUE(smaller.ok()) << smaller.status();
  EXPECT_THAT(smaller->notes[0], HasSubstr("Camera.newWidth is left out"));
  const std::string cut = absl::StrReplaceAll(kOrb3, {{"Camera.width: 512", "Camera.width: 1e12"}});
  EXPECT_THAT(std::string(ConvertRig(One("cut.yaml", cut)).status().message()),
              HasSubstr("must be a whole number"));
}

TEST(RigConvertTest, OffersTrustAsTheConvertersFlag) {
  const auto says = [](const char* to) {
    const std::string text = absl::StrReplaceAll(kKalibr, {{"254.9", to}});
    return std::string(ConvertRig(One("camchain.yaml", text)).status().message());
  };
  EXPECT_THAT(says("25.4"), HasSubstr("If it is right, say --trust-calibration"));
  const std::string negative = absl::StrReplaceAll(kKalibr, {{"[190.9,", "[-190.9,"}});
  EXPECT_THAT(std::string(ConvertRig(One("camchain.yaml", negative)).status().message()),
              ::testing::Not(HasSubstr("trust")));
}

TEST(RigConvertTest, SaysWhatIsWrong) {
  const struct {
    std::string from, to, says;
  } cases[] = {{"camera_model: ds", "camera_model: eucm", "cam1.camera_model is 'eucm'"},
               {"cam1:", "other:", "cam1 is missing"},
               {"T_cn_cnm1", "T_other", "cam1.T_cn_cnm1 is no list of 16"},
               {"equidistant", "fov", "cam0.distortion_model: a lens that is 'fov'"},
               {"[512, 512]", "[512]", "cam0.resolution is no list of 2"},
               {"254.9", "25.4", "can't be"},
               {"-0.101", "0.101", "left and right exchanged, or is the motion inverted?"},
               {"-0.101", "-101", "the cameras are 101 m apart"},
               {"  distortion_model: equidistant\n", "", "cam0.distortion_model is missing, and"},
               {"distortion_model: equidistant", "distortion_model: none", "is none, and"},
               {"  timeshift_cam_imu: 0.0\n", "", "is of one of cam0 and cam1 alone"},
               {"shift_cam_imu: 0.004", "shift_cam_imu: .nan", "cam0.timeshift_cam_imu is no"},
               {"[512, 512]", "[512.9, 512]", "is 512.9, must be a whole number"},
               {"[512, 512]", "[1e12, 512]", "is 1e+12, must be a whole number"},
               {"  camera_model: ds", "  resolution: [1, 1]\n  camera_model: ds",
                "resolution is there twice"},
               {"[190.9,", "[-190.9,", "can't be: must be finite and above 0"}};
  for (const auto& [from, to, says] : cases) {
    const std::string text = absl::StrReplaceAll(kKalibr, {{from, to}});
    const absl::Status status = ConvertRig(One("camchain.yaml", text)).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << to << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
    EXPECT_THAT(std::string(status.message()), HasSubstr("camchain.yaml"));
  }
  EXPECT_THAT(std::string(ConvertRig(One("other.yaml", "a: 1\n")).status().message()),
              HasSubstr("no calibration of a known format (kalibr, ros"));
  RigFiles unknown = One("other.yaml", "a: 1\n");
  unknown.format = "matlab";
  EXPECT_THAT(std::string(ConvertRig(unknown).status().message()),
              HasSubstr("format 'matlab', known are kalibr"));
  EXPECT_THAT(std::string(ConvertRig(One("rig.yaml", "rig: 1\n")).status().message()),
              HasSubstr("is a rig file already"));
  EXPECT_TRUE(absl::IsNotFound(
      ConvertRig({.paths = {"/nowhere.yaml"}, .format = "", .size = {}, .trust = false}).status()));
}

}  // namespace
}  // namespace corbslam::client_agent

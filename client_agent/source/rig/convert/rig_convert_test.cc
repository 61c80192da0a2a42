#include "client_agent/source/rig/convert/rig_convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/rig/convert/convert_test_files.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/camera/pair_geometry.h"

namespace corbslam::client_agent {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

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
  EXPECT_TRUE(converted->notes.empty());
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

TEST(RigConvertTest, ReadsOneCameraOfKalibr) {
  const std::string both = kKalibr;
  const auto one = ConvertRig(One("camchain.yaml", both.substr(0, both.find("cam1:"))));
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->format, "kalibr");
  EXPECT_EQ(one->rig.kind, RigKind::kMonocular);
  ASSERT_EQ(one->rig.cameras.size(), 1U);
  EXPECT_EQ(std::get<Equidistant>(one->rig.cameras[0].raw.lens).k1, 0.0034);
  // It is said, for a file may have lost its second camera.
  EXPECT_THAT(one->notes, Contains(HasSubstr("there is no cam1")));
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
  const auto one = ConvertRig(One("mono.yaml", mono));
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->rig.kind, RigKind::kMonocular);
  EXPECT_EQ(one->rig.cameras.size(), 1U);
  EXPECT_THAT(one->notes, Contains(HasSubstr("no metres")));
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
  EXPECT_THAT(says("R: [1,", "R: [-1,"), HasSubstr("R holds no rotation"));
  EXPECT_THAT(says("P: [718.8,", "P: [0,"), HasSubstr("was this camera calibrated?"));
  EXPECT_THAT(says("binning_x: 0", "binning_x: 2"), HasSubstr("binning_x is 2"));
  EXPECT_THAT(says("x_offset: 0", "x_offset: 8"), HasSubstr("roi.x_offset is 8"));
  EXPECT_THAT(says("K: [718.8, 0,", "K: [718.8, 3,"), HasSubstr("K has a skew of 3 px"));
  EXPECT_THAT(says("width: 1241", "width: 1241.5"), HasSubstr("must be a whole number"));
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

}  // namespace
}  // namespace corbslam::client_agent

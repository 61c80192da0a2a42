#include "client_agent/source/rig/rig_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_replace.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr char kDepthCamera[] = R"(rig: 1
kind: rgbd
cameras:
  - {size_px: [640, 480], focal_px: [525, 525], principal_px: [319.5, 239.5]}
depth:
  units_per_m: 1000
  no_depth: [2047, 65535]
  time_offset_s: 0.012
  camera: {size_px: [512, 424], focal_px: [365, 365], principal_px: [255, 210], lens: radtan, lens_numbers: [0.1, 0.02, 0, 0]}
  colour_from_depth: [1, 0, 0, -0.025, 0, 1, 0, 0, 0, 0, 1, 0.003, 0, 0, 0, 1]
)";

constexpr char kStereo[] = R"(rig: 1
kind: stereo
cameras:
  - size_px: [752, 480]
    focal_px: [458.654, 457.296]
    principal_px: [367.215, 248.375]
    lens: radial-tangential
    lens_numbers: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
  - size_px: [752, 480]
    focal_px: [457.587, 456.134]
    principal_px: [379.999, 255.238]
    lens: equidistant
    lens_numbers: [-0.013, 0.021, -0.013, 0.003]
rectified: false
right_from_left: [1, 0, 0, -0.11,
                  0, 1, 0, 0.001,
                  0, 0, 1, 0,
                  0, 0, 0, 1]
rate_hz: 20
)";

constexpr char kRectified[] = R"(rig: 1
kind: stereo
cameras:
  - {size_px: [640, 400], focal_px: [400, 400], principal_px: [321, 199]}
  - {size_px: [640, 400], focal_px: [400, 400], principal_px: [329, 199]}
rectified: true
baseline_m: 0.075
)";

constexpr char kRgbd[] = R"(rig: 1
kind: rgbd
cameras:
  - size_px: [640, 480]
    focal_px: [525, 526]
    principal_px: [319.5, 239.5]
depth:
  units_per_m: 1000
close_depth_m: 3
)";

constexpr char kOne[] = R"(rig: 1
kind: monocular
cameras:
  - size_px: [512, 512]
    focal_px: [190.9, 190.8]
    principal_px: [254.9, 256.9]
    lens: equidistant
    lens_numbers: [0.0034, 0.0007, -0.0021, 0.0002]
body_from_camera: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
)";

constexpr char kImu[] = R"(imu:
  imu_from_camera: [[0.0148655429818, 0.999557249008, -0.0257744366974, 0.06],
                    [-0.999880929698, 0.0149672133247, 0.00375618835797, 0.01],
                    [0.00414029679422, 0.0257155299480, 0.999660727178, -0.02],
                    [0, 0, 0, 1]]
  rate_hz: 200
  gyro_noise: 1.6968e-04
  accel_noise: 2.0e-3
  gyro_walk: 1.9393e-05
  accel_walk: 3.0e-3
  time_offset_s: -0.0021
)";

std::string WriteText(const std::string& name, const std::string& text) {
  const std::string path = ::testing::TempDir() + "/" + name;
  std::ofstream(path) << text;
  return path;
}

absl::StatusOr<Rig> Read(const std::string& text) {
  return ReadRigFile(WriteText("rig.yaml", text));
}

TEST(RigFileTest, ReadsAPairThatIsNotRectified) {
  const auto rig = Read(kStereo);
  ASSERT_TRUE(rig.ok()) << rig.status();
  const auto calibration = CalibrationOf(*rig);
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  const auto& stereo = std::get<StereoCalibration>(*calibration);
  ASSERT_TRUE(stereo.raw.has_value());
  EXPECT_EQ(stereo.raw->left.fx_px, 458.654);
  EXPECT_EQ(std::get<RadialTangential>(stereo.raw->left.lens).p2, 1.76187114e-05);
  EXPECT_EQ(std::get<Equidistant>(stereo.raw->right.lens).k4, 0.003);
  EXPECT_EQ(stereo.raw->right_from_left.translation.x(), -0.11);
  EXPECT_EQ(stereo.raw->height_px, 480);
  EXPECT_FALSE(stereo.body_from_raw_left.has_value());
  EXPECT_NEAR(stereo.camera.close_depth_m, 40 * 0.11, 0.01);
  EXPECT_EQ(rig->rate_hz, 20);
}

TEST(RigFileTest, ReadsARectifiedPair) {
  const auto rig = Read(kRectified);
  ASSERT_TRUE(rig.ok()) << rig.status();
  const auto stereo = std::get<StereoCalibration>(CalibrationOf(*rig).value());
  EXPECT_FALSE(stereo.raw.has_value());
  EXPECT_EQ(stereo.camera.baseline_m, 0.075);
  EXPECT_EQ(stereo.camera.cx_px, 321);
  EXPECT_EQ(stereo.right_cx_offset_px, 8);
}

TEST(RigFileTest, YamlsTrueMayHaveCapitals) {
  for (const char* word : {"True", "TRUE"}) {
    const auto rig = Read(absl::StrReplaceAll(kRectified, {{"true", word}}));
    ASSERT_TRUE(rig.ok()) << rig.status();
    EXPECT_TRUE(rig->rectified);
  }
}

TEST(RigFileTest, ReadsOneCameraAlone) {
  const auto rig = Read(absl::StrCat(kOne, kImu));
  ASSERT_TRUE(rig.ok()) << rig.status();
  EXPECT_EQ(rig->kind, RigKind::kMonocular);
  EXPECT_EQ(SecondTimeOffset_ns(*rig), 0);
  const auto one = std::get<MonocularCalibration>(CalibrationOf(*rig).value());
  EXPECT_FALSE(one.camera.IsMetric());
  EXPECT_EQ(one.camera.close_depth_m, 0);
  EXPECT_EQ(one.camera.fx_px, 190.9);
  EXPECT_EQ(std::get<Equidistant>(one.lens).k3, -0.0021);
  EXPECT_EQ(one.body_from_raw->translation.x(), 0.1);
  EXPECT_TRUE(one.imu.has_value());
  // What is written reads back.
  auto again = Read(FormatRig(*rig, "a test"));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(
      again->imu->imu_from_camera.rotation.isApprox(rig->imu->imu_from_camera.rotation, 1e-12));
  again->imu = rig->imu;
  EXPECT_EQ(FormatRig(*again, ""), FormatRig(*rig, ""));
}

TEST(RigFileTest, OneCameraHasNothingOfTwo) {
  const std::string one = kOne;
  const struct {
    std::string text, says;
  } cases[] = {
      {one + "close_depth_m: 3\n", "close_depth_m"},
      {one + "baseline_m: 0.1\n", "baseline_m"},
      {one + "depth:\n  units_per_m: 1000\n", "depth"},
      {absl::StrReplaceAll(one, {{"body_from",
                                  "  - {size_px: [512, 512], focal_px: [190, 190], "
                                  "principal_px: [254, 256]}\nbody_from"}}),
       "given 2"},
      {absl::StrReplaceAll(one, {{"monocular", "mono"}}), "must be stereo, rgbd or monocular"}};
  for (const auto& [text, says] : cases) {
    EXPECT_THAT(std::string(Read(text).status().message()), HasSubstr(says)) << text;
  }
}

TEST(RigFileTest, ReadsAnRgbdCamera) {
  const auto rig = Read(kRgbd);
  ASSERT_TRUE(rig.ok()) << rig.status();
  const auto rgbd = std::get<RgbdCalibration>(CalibrationOf(*rig).value());
  EXPECT_EQ(rgbd.depth_units_per_m, 1000);
  EXPECT_EQ(rgbd.camera.baseline_m, 0.08);
  EXPECT_EQ(rgbd.camera.close_depth_m, 3);
  EXPECT_EQ(rgbd.camera.fy_px, 526);
}

TEST(RigFileTest, ReadsACameraOfDepth) {
  const auto rig = Read(kDepthCamera);
  ASSERT_TRUE(rig.ok()) << rig.status();
  ASSERT_TRUE(rig->depth.camera.has_value());
  EXPECT_EQ(rig->depth.camera->width_px, 512);
  EXPECT_EQ(std::get<RadialTangential>(rig->depth.camera->raw.lens).k2, 0.02);
  EXPECT_EQ(rig->depth.colour_from_depth.translation, Eigen::Vector3d(-0.025, 0, 0.003));
  EXPECT_EQ(rig->depth.no_depth, std::vector<double>({2047, 65535}));
  EXPECT_EQ(SecondTimeOffset_ns(*rig), 12'000'000);
}

TEST(RigFileTest, ReadsAnImu) {
  for (const char* text : {kStereo, kRgbd}) {
    const auto rig = Read(absl::StrCat(text, kImu));
    ASSERT_TRUE(rig.ok()) << rig.status();
    const auto calibration = CalibrationOf(*rig);
    ASSERT_TRUE(calibration.ok()) << calibration.status();
    const auto imu = std::visit([](const auto& kind) { return kind.imu; }, *calibration);
    ASSERT_TRUE(imu.has_value());
    EXPECT_EQ(imu->noise.gyro, 1.6968e-04);
    EXPECT_EQ(imu->noise.accel, 2e-3);
    EXPECT_EQ(imu->noise.gyro_walk, 1.9393e-05);
    EXPECT_EQ(imu->noise.accel_walk, 3e-3);
    EXPECT_EQ(imu->rate_hz, 200);
    EXPECT_EQ(imu->time_offset_s, -0.0021);
    EXPECT_EQ(imu->imu_from_camera.translation, Eigen::Vector3d(0.06, 0.01, -0.02));
    // The camera's x axis is the IMU's -y axis.
    EXPECT_LT((imu->imu_from_camera.rotation * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitY())
                  .norm(),
              0.02);
    EXPECT_TRUE(JudgeRig(*rig, "rig.yaml", false)->empty());
  }
  EXPECT_FALSE(std::get<RgbdCalibration>(CalibrationOf(*Read(kRgbd)).value()).imu.has_value());
}

TEST(RigFileTest, AnImusNumbersMayBeLeftOut) {
  const auto rig = Read(absl::StrCat(
      kStereo, "imu: {imu_from_camera: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\n"));
  ASSERT_TRUE(rig.ok()) << rig.status();
  EXPECT_FALSE(rig->imu->gyro_noise.has_value());
  const auto imu = std::get<StereoCalibration>(CalibrationOf(*rig).value()).imu;
  EXPECT_EQ(imu->noise.gyro, ImuNoise().gyro);
  EXPECT_EQ(imu->rate_hz, ImuCalibration().rate_hz);
  EXPECT_EQ(imu->time_offset_s, 0);
}

TEST(RigFileTest, TellsOfAnImuThatIsImprobable) {
  const struct {
    std::string from, to, says;
  } cases[] = {
      {"rate_hz: 200", "rate_hz: 10", "imu: a rate_hz of 10 is improbable"},
      {"gyro_noise: 1.6968e-04", "gyro_noise: 0.3", "imu: a gyro_noise of 0.3 is improbable"},
      {"accel_noise: 2.0e-3", "accel_noise: 2", "imu: an accel_noise of 2 is improbable"},
      {"gyro_walk: 1.9393e-05", "gyro_walk: 0.05", "imu: a gyro_walk of 0.05 is improbable"},
      {"accel_walk: 3.0e-3", "accel_walk: 1e-11", "imu: an accel_walk of 1e-11 is improbable"},
      {"0.00375618835797, 0.01", "0.00375618835797, 9", "the IMU is 9.0"}};
  for (const auto& [from, to, says] : cases) {
    const std::string text = absl::StrReplaceAll(kImu, {{from, to}});
    ASSERT_NE(text, kImu) << from;
    const auto rig = Read(absl::StrCat(kStereo, text));
    ASSERT_TRUE(rig.ok()) << rig.status();
    const auto findings = JudgeRig(*rig, "rig.yaml", false);
    ASSERT_TRUE(findings.ok()) << findings.status();
    ASSERT_EQ(findings->size(), 1u) << to;
    EXPECT_EQ(findings->front().code, "calibration-improbable");
    EXPECT_THAT(findings->front().text, HasSubstr("rig.yaml: "));
    EXPECT_THAT(findings->front().text, HasSubstr(says));
  }
  // 200 mg/s/sqrt(Hz) are no IMU's; with trust they are taken.
  Rig rig = Read(absl::StrCat(kStereo, kImu)).value();
  rig.imu->accel_noise = 200;
  EXPECT_THAT(std::string(JudgeRig(rig, "rig.yaml", false).status().message()),
              HasSubstr("an accel_noise of 200 can't be"));
  EXPECT_EQ(JudgeRig(rig, "rig.yaml", true)->size(), 1u);
}

TEST(RigFileTest, AMaskIsBesideTheFileAndOfThePicturesSize) {
  const std::string folder = ::testing::TempDir() + "/with_mask";
  std::filesystem::create_directories(folder);
  cv::Mat mask(480, 640, CV_8UC1, cv::Scalar(255));
  mask.rowRange(400, 480).setTo(0);
  ASSERT_TRUE(cv::imwrite(folder + "/mask.png", mask));
  const std::string path = WriteText("with_mask/rig.yaml", std::string(kRgbd) + "mask: mask.png\n");
  const auto rig = ReadRigFile(path);
  ASSERT_TRUE(rig.ok()) << rig.status();
  const auto rgbd = std::get<RgbdCalibration>(CalibrationOf(*rig).value());
  EXPECT_EQ(cv::countNonZero(rgbd.mask != mask), 0);

  ASSERT_TRUE(cv::imwrite(folder + "/mask.png", mask.colRange(0, 600)));
  EXPECT_THAT(std::string(CalibrationOf(*rig).status().message()), HasSubstr("a mask of 600x480"));
  EXPECT_THAT(std::string(JudgeRig(*rig, path, true).status().message()),
              HasSubstr("with_mask/rig.yaml: mask: "));
  std::filesystem::remove(folder + "/mask.png");
  EXPECT_THAT(std::string(CalibrationOf(*rig).status().message()), HasSubstr("mask.png"));
}

TEST(RigFileTest, WritesWhatItReads) {
  const std::string with_imu = absl::StrCat(kStereo, kImu);
  for (const char* text : {kStereo, kRectified, kRgbd, kDepthCamera, with_imu.c_str()}) {
    Rig rig = Read(text).value();
    rig.body_from_camera =
        Rigid3d{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized())),
                {0.1, -0.2, 0.3}};
    const std::string written = FormatRig(rig, "a test");
    const auto again = Read(written);
    ASSERT_TRUE(again.ok()) << again.status() << "\n" << written;
    ASSERT_EQ(again->cameras.size(), rig.cameras.size());
    for (size_t i = 0; i < rig.cameras.size(); ++i) {
      EXPECT_EQ(again->cameras[i].raw, rig.cameras[i].raw);
      EXPECT_EQ(again->cameras[i].width_px, rig.cameras[i].width_px);
    }
    EXPECT_LT(again->body_from_camera->rotation.angularDistance(rig.body_from_camera->rotation),
              1e-12);
    EXPECT_EQ(again->body_from_camera->translation, rig.body_from_camera->translation);
    EXPECT_EQ(again->baseline_m, rig.baseline_m);
    EXPECT_EQ(again->rectified, rig.rectified);
    EXPECT_EQ(again->depth.units_per_m, rig.depth.units_per_m);
    EXPECT_EQ(again->depth.no_depth, rig.depth.no_depth);
    EXPECT_EQ(again->depth.colour_from_depth.translation, rig.depth.colour_from_depth.translation);
    ASSERT_EQ(again->depth.camera.has_value(), rig.depth.camera.has_value());
    if (rig.depth.camera.has_value()) {
      EXPECT_EQ(again->depth.camera->raw, rig.depth.camera->raw);
    }
    EXPECT_EQ(SecondTimeOffset_ns(*again), SecondTimeOffset_ns(rig));
    EXPECT_EQ(again->rate_hz, rig.rate_hz);
    EXPECT_EQ(again->close_depth_m, rig.close_depth_m);
    ASSERT_EQ(again->imu.has_value(), rig.imu.has_value());
    if (!rig.imu.has_value()) continue;
    EXPECT_LT(
        again->imu->imu_from_camera.rotation.angularDistance(rig.imu->imu_from_camera.rotation),
        1e-12);
    EXPECT_EQ(again->imu->imu_from_camera.translation, rig.imu->imu_from_camera.translation);
    EXPECT_EQ(again->imu->rate_hz, rig.imu->rate_hz);
    EXPECT_EQ(again->imu->gyro_noise, rig.imu->gyro_noise);
    EXPECT_EQ(again->imu->accel_noise, rig.imu->accel_noise);
    EXPECT_EQ(again->imu->gyro_walk, rig.imu->gyro_walk);
    EXPECT_EQ(again->imu->accel_walk, rig.imu->accel_walk);
    EXPECT_EQ(again->imu->time_offset_s, rig.imu->time_offset_s);
  }
}

TEST(RigFileTest, RefusesByNameWhatNoRigHas) {
  const struct {
    std::string file, from, to, says;
  } cases[] = {
      {kStereo, "rig: 1", "rig: 2", "rig is 2"},
      {kStereo, "rig: 1\n", "", "rig is 0"},
      {kStereo, "kind: stereo", "kind: mono", "kind is 'mono', must be stereo, rgbd or monocular"},
      {kStereo, "rate_hz: 20", "rate: 20", "unknown field rate: known are"},
      {kStereo, "rate_hz: 20", "rate_hz: -3", "rate_hz is -3"},
      {kStereo, "rate_hz: 20", "rate_hz: often", "rate_hz is no finite number"},
      {kStereo, "rate_hz: 20", "depth: {units_per_m: 5}", "unknown field depth"},
      {kStereo, "rectified: false", "rectified: 'no'", "rectified is 'no', must be true or false"},
      {kStereo, "rectified: false", "rectified: true", "baseline_m is missing"},
      {kStereo, "right_from_left", "left_from_right", "unknown field left_from_right"},
      {kStereo, "-0.11", "-110", "is it in metres?"},
      {kStereo, "-0.11", "0.11", "mostly along +x"},
      {kStereo, "[-0.013, 0.021, -0.013, 0.003]", "[0.1]", "cameras[1].lens: 1 numbers"},
      {kStereo, "lens: equidistant", "lens: wide", "a lens that is 'wide'"},
      {kStereo, "    lens: equidistant\n", "", "cameras[1].lens is missing"},
      {kStereo, "    lens_numbers: [-0.013, 0.021, -0.013, 0.003]\n", "",
       "cameras[1].lens_numbers is missing"},
      {kStereo, "[-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]", "[]",
       "cameras[0].lens_numbers is missing"},
      {kStereo, "    lens: equidistant\n", "    lens: equidistant\n    lens: radtan\n",
       "lens is there twice"},
      {kRectified, "[640, 400]", "[640.5, 400]", "is 640.5, must be a whole number"},
      {kStereo, "[367.215, 248.375]", "[367.215]", "cameras[0].principal_px is no list of 2"},
      {kStereo, "[457.587, 456.134]", "[0, 456.134]", "fx_px is 0"},
      {kRectified, "[329, 199]", "[329, 203]", "principal_px's y is 199"},
      {kRectified, "0.075", "-0.075", "baseline_m is -0.075"},
      {kRectified, "[640, 400]", "[0, 400]", "a side of the cameras[0].size_px is 0"},
      {kRectified, "rectified: true", "rectified: false", "baseline_m is of rectified pairs"},
      {kRgbd, "depth:\n  units_per_m: 1000\n", "", "depth is missing"},
      {kRgbd, "units_per_m: 1000", "units_per_m: 0", "units_per_m is 0"},
      {kRgbd, "units_per_m", "units", "unknown field units"},
      {kRgbd, "cameras:", "camera:", "unknown field camera"},
      {kDepthCamera, "-0.025", "-25", "depth.colour_from_depth"},
      {kDepthCamera, "colour_from_depth", "depth_from_colour", "unknown field depth_from_colour"},
      {kDepthCamera, "  camera:", "  # camera:", "depth.camera is missing"},
      {kDepthCamera, "[365, 365]", "[-365, 365]", "depth's depth camera"},
      {kDepthCamera, "offset_s: 0.012", "offset_s: 12", "differ by 12 s, must be at most 0.5"},
      {kDepthCamera, "[2047, 65535]", "none", "depth.no_depth is no list"}};
  for (const auto& [file, from, to, says] : cases) {
    const std::string text = absl::StrReplaceAll(file, {{from, to}});
    ASSERT_NE(text, file) << from;
    const absl::Status status = Read(text).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << to << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
    EXPECT_THAT(std::string(status.message()), HasSubstr("rig.yaml"));
  }
  EXPECT_TRUE(absl::IsNotFound(ReadRigFile("/nowhere/rig.yaml").status()));
}

TEST(RigFileTest, RefusesByNameWhatNoImuHas) {
  const struct {
    std::string from, to, says;
  } cases[] = {
      {"imu_from_camera", "T_cam_imu", "unknown field T_cam_imu: known are"},
      {"0.999557249008", "0.5", "imu.imu_from_camera is no motion: its first three columns"},
      {"-0.999880929698", "0.999880929698", "imu.imu_from_camera is no motion"},
      {"[0, 0, 0, 1]", "[0, 0, 0]", "imu.imu_from_camera is no list of 16"},
      {"[0, 0, 0, 1]", "[0, 0, 0, 2]", "instead of 0 0 0 1"},
      {"-0.0257744366974, 0.06", "-0.0257744366974, 60", "is it in metres?"},
      {"rate_hz: 200", "rate_hz: 0", "imu.rate_hz is 0"},
      {"rate_hz: 200", "rate_hz: fast", "imu.rate_hz is no finite number"},
      {"rate_hz: 200", "rate: 200", "unknown field rate"},
      {"gyro_noise: 1.6968e-04", "gyro_noise: 0", "imu.gyro_noise is 0, must be above 0"},
      {"accel_noise: 2.0e-3", "accel_noise: -1", "imu.accel_noise is -1"},
      {"accel_walk: 3.0e-3", "accel_walk: .nan", "imu.accel_walk is no finite number"},
      {"gyro_walk", "gyro_noise", "gyro_noise is there twice"},
      {"-0.0021", "-2.1", "imu.time_offset_s is -2.1, must be at most 0.5"}};
  for (const auto& [from, to, says] : cases) {
    const std::string text = absl::StrReplaceAll(kImu, {{from, to}});
    ASSERT_NE(text, kImu) << from;
    const absl::Status status = Read(absl::StrCat(kStereo, text)).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << to << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
    EXPECT_THAT(std::string(status.message()), HasSubstr("rig.yaml"));
  }
  EXPECT_THAT(std::string(Read(absl::StrCat(kStereo, "imu:\n")).status().message()),
              HasSubstr("imu holds no fields"));
  EXPECT_THAT(std::string(Read(absl::StrCat(kStereo, "imu: {rate_hz: 200}\n")).status().message()),
              HasSubstr("imu.imu_from_camera is missing"));
}

}  // namespace
}  // namespace corbslam::client_agent

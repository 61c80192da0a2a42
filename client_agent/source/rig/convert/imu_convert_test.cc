// What other systems' files say of an IMU.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/rig/convert/convert_test_files.h"
#include "client_agent/source/rig/convert/rig_convert.h"
#include "client_agent/source/rig/rig_file.h"

namespace corbslam::client_agent {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// As it is given to Kalibr.
constexpr char kKalibrImu[] = R"(#Accelerometers
accelerometer_noise_density: 1.86e-03   #Noise density (continuous-time)
accelerometer_random_walk:   4.33e-04   #Bias random walk

#Gyroscopes
gyroscope_noise_density:     1.87e-04
gyroscope_random_walk:       2.66e-05

rostopic:                    /imu0
update_rate:                 200.0
)";

// As Kalibr writes it.
constexpr char kKalibrWritten[] = R"(imu0:
  T_i_b:
  - [1.0, 0.0, 0.0, 0.0]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  accelerometer_noise_density: 0.00186
  accelerometer_random_walk: 0.000433
  gyroscope_noise_density: 0.000187
  gyroscope_random_walk: 2.66e-05
  model: calibrated
  rostopic: /imu0
  time_offset: 0.0
  update_rate: 200.0
)";

absl::StatusOr<ConvertedRig> Convert(const std::string& name, const std::string& text,
                                     const std::vector<std::string>& more = {}) {
  RigFiles files = One(name, text);
  files.paths.insert(files.paths.end(), more.begin(), more.end());
  return ConvertRig(files);
}

TEST(ImuConvertTest, KalibrsCamchainSaysWhereItSitsAndByWhichClock) {
  const auto converted = Convert("camchain-imucam.yaml", kKalibr);
  ASSERT_TRUE(converted.ok()) << converted.status();
  ASSERT_TRUE(converted->rig.imu.has_value());
  const StatedImu& imu = *converted->rig.imu;
  // T_cam_imu: x_cam = -y_imu + 0.05, y_cam = x_imu - 0.02.
  EXPECT_LT((imu.imu_from_camera * Eigen::Vector3d(0.05, -0.02, 0.01)).norm(), 1e-12);
  EXPECT_LT(
      (imu.imu_from_camera * Eigen::Vector3d(0.05, 0.98, 0.01) - Eigen::Vector3d::UnitX()).norm(),
      1e-12);
  // t_imu = t_cam + shift, and a rig has what is added to the IMU's.
  EXPECT_EQ(imu.time_offset_s, -0.004);
  EXPECT_FALSE(imu.gyro_noise.has_value());
  // The rig can be written and read again.
  EXPECT_TRUE(ReadRigText(FormatRig(converted->rig, "a test"), "rig").ok());
}

TEST(ImuConvertTest, KalibrsImuFileSaysItsNoiseWhicheverIsFirst) {
  for (const char* text : {kKalibrImu, kKalibrWritten}) {
    const std::string imu_file = WriteText("imu.yaml", text);
    const std::string camchain = WriteText("camchain-imucam.yaml", kKalibr);
    for (const auto& paths : {std::vector<std::string>{camchain, imu_file}, {imu_file, camchain}}) {
      RigFiles files = One("camchain-imucam.yaml", kKalibr);
      files.paths = paths;
      const auto converted = ConvertRig(files);
      ASSERT_TRUE(converted.ok()) << converted.status();
      const StatedImu& imu = *converted->rig.imu;
      EXPECT_EQ(imu.gyro_noise, 1.87e-4);
      EXPECT_EQ(imu.gyro_walk, 2.66e-5);
      EXPECT_EQ(imu.accel_noise, 1.86e-3);
      EXPECT_EQ(imu.accel_walk, 4.33e-4);
      EXPECT_EQ(imu.rate_hz, 200);
      EXPECT_EQ(imu.time_offset_s, -0.004);
      EXPECT_THAT(converted->notes, IsEmpty());
    }
  }
}

TEST(ImuConvertTest, RefusesKalibrsFilesThatDoNotFit) {
  const std::string imu_file = WriteText("imu.yaml", kKalibrImu);
  std::string without = absl::StrReplaceAll(kKalibr, {{"T_cam_imu", "T_cam_other"}});
  auto converted = Convert("camchain.yaml", without, {imu_file});
  EXPECT_THAT(std::string(converted.status().message()),
              HasSubstr("the camchain does not say where it sits (cam0.T_cam_imu)"));
  // Without the IMU's file it is a rig without an IMU.
  converted = Convert("camchain.yaml", without);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_FALSE(converted->rig.imu.has_value());
  EXPECT_THAT(converted->notes, Contains(HasSubstr("cam0.timeshift_cam_imu of 0.004 s")));
  converted = Convert("camchain.yaml", kKalibr, {WriteText("target.yaml", "tagSize: 0.088\n")});
  EXPECT_THAT(std::string(converted.status().message()),
              HasSubstr("target.yaml: is no imu.yaml of Kalibr's"));
  const std::string second =
      absl::StrReplaceAll(kKalibrWritten, {{"time_offset: 0.0", "time_offset: 0.02"}});
  converted = Convert("camchain.yaml", kKalibr, {WriteText("imu.yaml", second)});
  EXPECT_THAT(std::string(converted.status().message()), HasSubstr("imu0.time_offset is 0.02"));
}

// Both cameras by another clock than the IMU: the cameras' part is good.
TEST(ImuConvertTest, LeavesOutAnImuOfAnotherClock) {
  const std::string apart =
      absl::StrReplaceAll(kKalibr, {{"timeshift_cam_imu: 0.004", "timeshift_cam_imu: 12.004"},
                                    {"timeshift_cam_imu: 0.0\n", "timeshift_cam_imu: 12.0\n"}});
  const auto converted = Convert("camchain.yaml", apart);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_FALSE(converted->rig.imu.has_value());
  EXPECT_THAT(converted->notes,
              Contains(HasSubstr("its clock and the camera's are 12.004 s apart")));
}

TEST(ImuConvertTest, NoiseOfZeroIsNoNoiseThatIsKnown) {
  const std::string zero = absl::StrReplaceAll(kKalibrImu, {{"1.86e-03", "0.0"}});
  const auto converted = Convert("camchain.yaml", kKalibr, {WriteText("imu.yaml", zero)});
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_FALSE(converted->rig.imu->accel_noise.has_value());
  EXPECT_EQ(converted->rig.imu->gyro_noise, 1.87e-4);
  EXPECT_THAT(converted->notes, Contains(HasSubstr("the IMU's accelerometer's noise is 0")));
}

TEST(ImuConvertTest, TellsOfNoiseThatIsImprobable) {
  const std::string odd = absl::StrReplaceAll(kKalibrImu, {{"1.87e-04", "0.5"}});
  const auto converted = Convert("camchain.yaml", kKalibr, {WriteText("imu.yaml", odd)});
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_THAT(converted->notes, Contains(HasSubstr("imu: a gyro_noise of 0.5 is improbable")));
}

constexpr char kBasaltImu[] = R"({"value0": {
  "T_imu_cam": [
    {"px": 0.01, "py": 0.02, "pz": 0.03, "qx": 0, "qy": 0, "qz": 0.7071067811865476, "qw": 0.7071067811865476},
    {"px": 0.01, "py": 0.12, "pz": 0.03, "qx": 0, "qy": 0, "qz": 0.7071067811865476, "qw": 0.7071067811865476}],
  "intrinsics": [
    {"camera_type": "ds", "intrinsics": {"fx": 349.7, "fy": 349.8, "cx": 365.9, "cy": 249.2, "xi": -0.27, "alpha": 0.566}},
    {"camera_type": "ds", "intrinsics": {"fx": 361.6, "fy": 361.7, "cx": 379.4, "cy": 255.3, "xi": -0.27, "alpha": 0.566}}],
  "resolution": [[752, 480], [752, 480]],
  "calib_accel_bias": [-0.003, 0.02, 0.08, 0, 0, 0, 0, 0, 0],
  "calib_gyro_bias": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
  "imu_update_rate": 200.0,
  "accel_noise_std": [0.016, 0.015, 0.014],
  "gyro_noise_std": [0.000282, 0.000282, 0.000282],
  "accel_bias_std": [0.001, 0.001, 0.001],
  "gyro_bias_std": [0.0001, 0.0001, 0.0001],
  "cam_time_offset_ns": 2500000}})";

TEST(ImuConvertTest, ReadsBasalts) {
  const auto converted = Convert("calibration.json", kBasaltImu);
  ASSERT_TRUE(converted.ok()) << converted.status();
  const StatedImu& imu = *converted->rig.imu;
  EXPECT_LT((imu.imu_from_camera.translation - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 1e-12);
  EXPECT_EQ(imu.accel_noise, 0.016);
  EXPECT_EQ(imu.gyro_noise, 0.000282);
  EXPECT_EQ(imu.accel_walk, 0.001);
  EXPECT_EQ(imu.gyro_walk, 0.0001);
  EXPECT_EQ(imu.rate_hz, 200);
  EXPECT_NEAR(imu.time_offset_s, -0.0025, 1e-12);
  EXPECT_THAT(converted->notes, ::testing::ElementsAre(HasSubstr("calib_accel_bias is left out")));
  // Older files have one number for all axes.
  const auto older = Convert("calibration.json",
                             absl::StrReplaceAll(kBasaltImu, {{"[0.016, 0.015, 0.014]", "0.02"}}));
  ASSERT_TRUE(older.ok()) << older.status();
  EXPECT_EQ(older->rig.imu->accel_noise, 0.02);
}

constexpr char kOkvisImu[] = R"(%YAML:1.0
cameras:
     - {T_SC: [1.0, 0.0, 0.0, -0.02, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        image_dimension: [752, 480],
        distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05],
        distortion_type: radialtangential,
        focal_length: [458.6, 457.3],
        principal_point: [367.2, 248.4]}
     - {T_SC: [1.0, 0.0, 0.0, 0.09, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        image_dimension: [752, 480],
        distortion_coefficients: [-0.29, 0.08, -0.0002, -2.2e-05],
        distortion_type: radialtangential,
        focal_length: [457.6, 456.1],
        principal_point: [379.9, 255.2]}
camera_parameters:
     timestamp_tolerance: 0.005
     image_delay: 0.0
imu_parameters:
    use: true
    a_max: 176.0
    g_max: 7.8
    sigma_g_c: 12.0e-4
    sigma_a_c: 8.0e-3
    sigma_bg: 0.03
    sigma_ba: 0.1
    sigma_gw_c: 4.0e-6
    sigma_aw_c: 4.0e-5
    g: 9.81007
    T_BS: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
)";

TEST(ImuConvertTest, ReadsOkvis2s) {
  const auto converted = Convert("okvis2.yaml", kOkvisImu);
  ASSERT_TRUE(converted.ok()) << converted.status();
  const StatedImu& imu = *converted->rig.imu;
  EXPECT_EQ(imu.imu_from_camera.translation.x(), -0.02);
  EXPECT_EQ(imu.gyro_noise, 12e-4);
  EXPECT_EQ(imu.accel_noise, 8e-3);
  EXPECT_EQ(imu.gyro_walk, 4e-6);
  EXPECT_EQ(imu.accel_walk, 4e-5);
  EXPECT_FALSE(imu.rate_hz.has_value());
  EXPECT_THAT(converted->notes, IsEmpty());
  const auto late = Convert(
      "okvis2.yaml", absl::StrReplaceAll(kOkvisImu, {{"image_delay: 0.0", "image_delay: 0.03"}}));
  ASSERT_TRUE(late.ok()) << late.status();
  EXPECT_THAT(late->notes, Contains(HasSubstr("image_delay of 0.03 s is left out")));
  const auto broken = Convert(
      "okvis2.yaml", absl::StrReplaceAll(kOkvisImu, {{"sigma_a_c: 8.0e-3", "sigma_a_c: some"}}));
  EXPECT_THAT(std::string(broken.status().message()), HasSubstr("sigma_a_c is no finite number"));
}

TEST(ImuConvertTest, ReadsOrbSlam3s) {
  const auto converted =
      Convert("EuRoC.yaml", absl::StrCat(kOrb3, "IMU.NoiseGyro: 1.7e-04 # 1.6968e-04\n",
                                         "IMU.NoiseAcc: 2.0e-03\nIMU.GyroWalk: 1.9393e-05\n",
                                         "IMU.AccWalk: 3.e-03\nIMU.Frequency: 200.0\n"));
  ASSERT_TRUE(converted.ok()) << converted.status();
  const StatedImu& imu = *converted->rig.imu;
  EXPECT_EQ(imu.imu_from_camera.translation, Eigen::Vector3d(0.04, 0.05, 0.06));
  EXPECT_EQ(imu.gyro_noise, 1.7e-4);
  EXPECT_EQ(imu.accel_noise, 2e-3);
  EXPECT_EQ(imu.gyro_walk, 1.9393e-5);
  EXPECT_EQ(imu.accel_walk, 3e-3);
  EXPECT_EQ(imu.rate_hz, 200);
}

TEST(ImuConvertTest, ReadsVinsFusions) {
  WriteText("cam0.yaml", R"(%YAML:1.0
---
model_type: PINHOLE
camera_name: camera
image_width: 752
image_height: 480
distortion_parameters:
   k1: -0.28
   k2: 0.07
   p1: 0.0002
   p2: 1.7e-05
projection_parameters:
   fx: 458.6
   fy: 457.3
   cx: 367.2
   cy: 248.4
)");
  const std::string main = R"(%YAML:1.0
imu: 1
num_of_cam: 2
imu_topic: "/imu0"
cam0_calib: "cam0.yaml"
cam1_calib: "cam0.yaml"
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
acc_n: 0.1
gyr_n: 0.01
acc_w: 0.001
gyr_w: 0.0001
estimate_td: 0
td: 0.005
)";
  const auto converted = Convert("vins.yaml", main);
  ASSERT_TRUE(converted.ok()) << converted.status();
  ASSERT_TRUE(converted->rig.imu.has_value());
  EXPECT_EQ(converted->rig.imu->imu_from_camera.translation.x(), -0.02);
  EXPECT_EQ(converted->rig.imu->time_offset_s, -0.005);
  EXPECT_FALSE(converted->rig.imu->accel_noise.has_value());
  EXPECT_THAT(converted->notes, Contains(HasSubstr("acc_n, gyr_n, acc_w and gyr_w are left out")));
  const auto without = Convert("vins.yaml", absl::StrReplaceAll(main, {{"imu: 1", "imu: 0"}}));
  ASSERT_TRUE(without.ok()) << without.status();
  EXPECT_FALSE(without->rig.imu.has_value());
}

TEST(ImuConvertTest, ReadsEurocs) {
  const std::string folder = ::testing::TempDir() + "/euroc_with_imu";
  for (const char* sensor : {"cam0", "cam1", "imu0"}) {
    std::filesystem::create_directories(absl::StrCat(folder, "/mav0/", sensor));
  }
  const std::string camera =
      R"(T_BS: {cols: 4, rows: 4, data: [1, 0, 0, X, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.6, 457.3, 367.2, 248.4]
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]
)";
  const auto write = [&](const std::string& sensor, const std::string& text) {
    WriteText(absl::StrCat("euroc_with_imu/mav0/", sensor, "/sensor.yaml"), text);
  };
  write("cam0", absl::StrReplaceAll(camera, {{"X", "-0.02"}}));
  write("cam1", absl::StrReplaceAll(camera, {{"X", "0.09"}}));
  write("imu0",
        "sensor_type: imu\nT_BS: {cols: 4, rows: 4, data: [1, 0, 0, 0.05, 0, 1, 0, 0, 0, 0, 1, 0, "
        "0, 0, 0, 1]}\nrate_hz: 200\ngyroscope_noise_density: 1.6968e-04\n");
  RigFiles files = One("any.yaml", "a: 1");
  files.paths = {folder};
  const auto converted = ConvertRig(files);
  ASSERT_TRUE(converted.ok()) << converted.status();
  const StatedImu& imu = *converted->rig.imu;
  EXPECT_NEAR(imu.imu_from_camera.translation.x(), -0.07, 1e-12);
  EXPECT_EQ(imu.rate_hz, 200);
  EXPECT_EQ(imu.gyro_noise, 1.6968e-04);
  EXPECT_FALSE(imu.accel_walk.has_value());
}

}  // namespace
}  // namespace corbslam::client_agent

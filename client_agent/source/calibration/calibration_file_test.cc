// Calibration files that hold what no camera has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "absl/strings/str_replace.h"
#include "client_agent/source/euroc_calibration.h"
#include "client_agent/source/tum_calibration.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

std::string WriteFile(const std::string& name, const std::string& text) {
  const std::string folder = ::testing::TempDir() + "/calibration_file_test_" +
                             ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::filesystem::create_directories(folder);
  const std::string path = folder + "/" + name;
  std::ofstream(path) << text;
  return path;
}

constexpr char kEurocYaml[] = R"(%YAML:1.0
T_BS:
  cols: 4
  rows: 4
  data: [1, 0, 0, 0.11,
         0, 1, 0, 0,
         0, 0, 1, 0,
         0.0, 0.0, 0.0, 1.0]
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.6, 457.3, 367.2, 248.4]
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]
)";

TEST(EurocCalibrationTest, ReadsAGoodOne) {
  const auto camera = ReadEurocCamera(WriteFile("sensor.yaml", kEurocYaml));
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_EQ(camera->width_px, 752);
  EXPECT_EQ(camera->body_from_camera.translation.x(), 0.11);
}

TEST(EurocCalibrationTest, RefusesWhatNoCameraHas) {
  const struct {
    std::string from, to, says;
  } cases[] = {{"[1, 0, 0, 0.11", "[.Nan, 0, 0, 0.11", "T_BS data is no list of 16 finite"},
               {"0.11", ".Inf", "T_BS data is no list of 16 finite"},
               {"[1, 0, 0, 0.11", "[-1, 0, 0, 0.11", "T_BS holds no rotation"},
               {"[1, 0, 0, 0.11", "[2, 0, 0, 0.11", "T_BS holds no rotation"},
               {"752", "1e300", "a side of the resolution is 1e+300"},
               {"480", "-1", "a side of the resolution is -1"},
               {"458.6", ".Nan", "intrinsics is no list of 4 finite"},
               {"radial-tangential", "equidistant", "distortion_model is 'equidistant'"}};
  for (const auto& [from, to, says] : cases) {
    const std::string yaml = absl::StrReplaceAll(kEurocYaml, {{from, to}});
    const absl::Status status = ReadEurocCamera(WriteFile("sensor.yaml", yaml)).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << to << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
  }
}

TEST(EurocCalibrationTest, ReadsOneWithoutItsFirstLine) {
  const std::string yaml = absl::StrReplaceAll(kEurocYaml, {{"%YAML:1.0\n", "# Of a camera.\n"}});
  const auto camera = ReadEurocCamera(WriteFile("sensor.yaml", yaml));
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_EQ(camera->height_px, 480);
}

TEST(EurocCalibrationTest, RefusesBrokenYaml) {
  const struct {
    std::string from, to, says;
  } cases[] = {{"T_BS:", "t_bs:", "T_BS"},
               {"data: [", "://a: [", "T_BS data is no list"},
               {"1.0]", "1.0", "line"},
               {"camera_model: pinhole", "", "camera_model is ''"},
               // OpenCV's parser never came back from these.
               {"T_BS:", "T_BS:!!binary |, \xbf\xbf", "line"},
               {"480]", "\xff\xff, 480]", "resolution is no list of 2"}};
  for (const auto& [from, to, says] : cases) {
    const std::string yaml = absl::StrReplaceAll(kEurocYaml, {{from, to}});
    const absl::Status status = ReadEurocCamera(WriteFile("sensor.yaml", yaml)).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << to << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
    EXPECT_THAT(std::string(status.message()), HasSubstr("sensor.yaml"));
  }
}

TEST(TumCalibrationTest, RefusesWhatNoCameraHas) {
  const struct {
    std::string line, says;
  } cases[] = {{"depth_units_per_m: inf", "depth_units_per_m inf"},
               {"depth_units_per_m: 0", "depth_units_per_m 0"},
               {"fx: nan", "fx_px is nan"},
               {"fy: -5", "fy_px is -5"},
               {"k1: inf", "k1"}};
  for (const auto& [line, says] : cases) {
    const std::filesystem::path path = WriteFile("calibration.yaml", line + "\n");
    const absl::Status status = ReadTumCalibration(path.parent_path(), 640, 480).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << line << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
  }
}

}  // namespace
}  // namespace corbslam

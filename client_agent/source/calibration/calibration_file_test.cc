// Tests calibration files that hold what no camera has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/calibration/euroc_calibration.h"
#include "client_agent/source/calibration/kitti_calibration.h"
#include "client_agent/source/calibration/rgbd_calibration.h"
#include "slam/util/testing/case_name.h"

namespace corbslam::client_agent {
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
  } cases[] = {
      {"[1, 0, 0, 0.11", "[.Nan, 0, 0, 0.11", "T_BS data is no list of 16 finite"},
      {"0.11", ".Inf", "T_BS data is no list of 16 finite"},
      {"[1, 0, 0, 0.11", "[-1, 0, 0, 0.11",
       "T_BS is no motion: its first three columns hold no rotation"},
      {"[1, 0, 0, 0.11", "[2, 0, 0, 0.11",
       "T_BS is no motion: its first three columns hold no rotation"},
      {"0.0, 0.0, 0.0, 1.0", "0.1, 0.0, 0.0, 1.0", "T_BS is no motion: its last row is 0.1"},
      {"0.11", "110", "T_BS is no motion: the camera is 110 m from the body"},
      {"resolution:", "camera_model: pinhole\nresolution:", "camera_model is there twice"},
      {"1.7e-05]", "1.7e-05, 0, 0.1]",
       "6 numbers of a lens that is radial-tangential, which has none, 4, 5 or 8"},
      {"radial-tangential", "fov",
       "distortion_model is 'fov', only radial-tangential, radtan, equidistant"},
      {"752", "1e300", "a side of the resolution is 1e+300"},
      {"480", "-1", "a side of the resolution is -1"},
      {"458.6", ".Nan", "intrinsics is no list of 4 finite"},
      {"radial-tangential\ndistortion_coefficients: [-0.28,",
       "equidistant\ndistortion_coefficients: [0, -0.28,",
       "5 numbers of a lens that is equidistant, which has 4"}};
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

TEST(EurocCalibrationTest, ReadsWhatOthersWrite) {
  const struct {
    std::string from, to;
    double k3;
  } cases[] = {{"radial-tangential", "radtan", 0},
               {"1.7e-05]", "1.7e-05, 0.25]", 0.25},
               {"1.7e-05]", "1.7e-05, 0.25, 0, 0, 0]", 0.25}};
  for (const auto& [from, to, k3] : cases) {
    const std::string yaml = absl::StrReplaceAll(kEurocYaml, {{from, to}});
    const auto camera = ReadEurocCamera(WriteFile("sensor.yaml", yaml));
    ASSERT_TRUE(camera.ok()) << to << ": " << camera.status();
    EXPECT_EQ(std::get<RadialTangential>(camera->intrinsics.lens).k3, k3) << to;
  }
}

RgbdCalibrationQuery QueryOf(const std::string& directory) {
  RgbdCalibrationQuery query;
  query.folders = {directory};
  query.first_picture = directory + "/rgb/1.png";
  query.width_px = 640;
  query.height_px = 480;
  return query;
}

RgbdCalibrationQuery QueryOfFile(const std::string& name, const std::string& text) {
  return QueryOf(std::filesystem::path(WriteFile(name, text)).parent_path());
}

constexpr char kRgbdYaml[] = "fx: 525\nfy: 525.5\ncx: 319.5\ncy: 239.5\n";

struct RgbdCase {
  std::string line;  // Goes beside those of kRgbdYaml, or instead of one of the same field.
  std::string says;
};
class RefusedRgbdTest : public ::testing::TestWithParam<RgbdCase> {};

std::string WithLine(const std::string& line) {
  std::string yaml;
  const std::string key = line.substr(0, line.find(':') + 1);
  for (const char* own : {"fx: 525", "fy: 525.5", "cx: 319.5", "cy: 239.5"}) {
    if (key != std::string(own).substr(0, 3)) absl::StrAppend(&yaml, own, "\n");
  }
  return yaml + line + "\n";
}

TEST_P(RefusedRgbdTest, IsNamed) {
  const absl::Status status =
      FindRgbdCalibration(QueryOfFile("calibration.yaml", WithLine(GetParam().line))).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << GetParam().line << ": " << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("calibration.yaml"));
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedRgbdTest,
    ::testing::Values(RgbdCase{"depth_units_per_m: inf", "depth_units_per_m is no finite number"},
                      RgbdCase{"depth_units_per_m: 0", "depth_units_per_m 0"},
                      RgbdCase{"fx: nan", "fx is no finite number"},
                      RgbdCase{"fx: abc", "fx is no finite number"},
                      RgbdCase{"fy: -5", "fy_px is -5"}, RgbdCase{"k1: inf", "k1"},
                      RgbdCase{"k4: 0.1", ":5: unknown field k4"},
                      RgbdCase{"fx: 525\nfx: 526", "fx is there twice"},
                      RgbdCase{"fx:", "fx is no finite number"},
                      RgbdCase{"- 1", "calibration.yaml"},
                      RgbdCase{"width: 320\nheight: 240", "these intrinsics are of 320x240"},
                      // The numbers are in the order fx, cx, fy, cy.
                      RgbdCase{"cx: 525", "cx 525 px of 640 can't be"},
                      // The numbers are for pictures of twice the size, and of half.
                      RgbdCase{"cx: 639.5", "cx 639.5 px of 640 can't be"},
                      RgbdCase{"cy: 119.5", "cy 119.5 px of 480 can't be"},
                      RgbdCase{"fx: 20", "fx 20 px with 640 px of width can't be"}),
    testing::NamedBy(&RgbdCase::line));

TEST(RgbdCalibrationTest, NeedsEachIntrinsic) {
  for (const char* field : {"fx", "fy", "cx", "cy"}) {
    const std::string yaml = absl::StrReplaceAll(kRgbdYaml, {{field, "# "}});
    const absl::Status status = FindRgbdCalibration(QueryOfFile("calibration.yaml", yaml)).status();
    EXPECT_THAT(std::string(status.message()), HasSubstr(absl::StrCat(field, " is missing")));
  }
}

TEST(RgbdCalibrationTest, TakesTheImprobableWhenTold) {
  RgbdCalibrationQuery query = QueryOfFile("calibration.yaml", WithLine("cx: 500"));
  EXPECT_THAT(std::string(FindRgbdCalibration(query).status().message()),
              HasSubstr("?trust-calibration"));
  query.trust = true;
  const auto found = FindRgbdCalibration(query);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->calibration.camera.cx_px, 500);
  ASSERT_EQ(found->findings.size(), 1u);
  EXPECT_EQ(found->findings[0].code, "calibration-improbable");
}

TEST(RgbdCalibrationTest, ReadsItsOwnAndEth3dsFile) {
  auto found = FindRgbdCalibration(QueryOfFile(
      "calibration.yaml", absl::StrCat("\xef\xbb\xbf", kRgbdYaml, "k1: 0.1 # a comment\r\n")));
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->calibration.camera.fy_px, 525.5);
  EXPECT_EQ(std::get<RadialTangential>(found->calibration.lens).k1, 0.1);
  EXPECT_EQ(found->calibration.depth_units_per_m, 5000);
  std::filesystem::remove(WriteFile("calibration.yaml", ""));
  found = FindRgbdCalibration(QueryOfFile("calibration.txt", "\t526.25 526.5 319 240\r\n"));
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->calibration.camera.fx_px, 526.25);
  EXPECT_TRUE(std::get<RadialTangential>(found->calibration.lens).IsZero());
}

TEST(RgbdCalibrationTest, RefusesAnEth3dFileOfAnotherForm) {
  for (const char* text : {"", "525 525 319\n", "525 525 319 240 0.1\n",
                           "525 525 319 240\n525 525 319 240\n", "525 525 319 x\n"}) {
    std::filesystem::remove_all(::testing::TempDir() + "/calibration_file_test_" +
                                "RefusesAnEth3dFileOfAnotherForm");
    const absl::Status status = FindRgbdCalibration(QueryOfFile("calibration.txt", text)).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << text << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("calibration.txt"));
  }
}

std::string MakeFolder(const std::string& name) {
  const std::string folder = ::testing::TempDir() + "/calibration_file_test_folders/" + name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

TEST(RgbdCalibrationTest, GuessesNothingFromANameThatIsNotTums) {
  for (const char* name : {"seq", "fr1", "my_fr2_room", "freiburg3", "rgbd_dataset_freiburg1",
                           "rgbd_dataset_freiburg1_kitchen", "rgbd_dataset_freiburg4_xyz",
                           "rgbd_dataset_freiburg1_xyz_2", "cables_1", "living_room_traj0"}) {
    const absl::Status status = FindRgbdCalibration(QueryOf(MakeFolder(name))).status();
    EXPECT_TRUE(absl::IsNotFound(status)) << name << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("no calibration. Put calibration.yaml"));
    EXPECT_THAT(std::string(status.message()), HasSubstr("?camera=NAME"));
  }
}

TEST(RgbdCalibrationTest, KnowsTumsOwnFoldersAlsoThroughALink) {
  const std::string folder = MakeFolder("rgbd_dataset_freiburg2_desk");
  const std::string link = MakeFolder("links") + "/seq";
  std::filesystem::create_directory_symlink(folder, link);
  for (const std::string& path : {folder, link, folder + "/."}) {
    const auto found = FindRgbdCalibration(QueryOf(path));
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(found->calibration.camera.fx_px, 520.908620);
    EXPECT_THAT(found->from, HasSubstr("freiburg2"));
  }
}

TEST(RgbdCalibrationTest, BelievesTheCommentOfTumsLists) {
  const std::string folder = MakeFolder("copy");
  std::ofstream(folder + "/groundtruth.txt")
      << "# ground truth trajectory\n# file: 'rgbd_dataset_freiburg1_xyz.bag'\n1 0 0 0 0 0 0 1\n";
  const RgbdCalibrationQuery query = QueryOf(folder);
  const auto found = FindRgbdCalibration(query);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->calibration.camera.fx_px, 517.306408);
  EXPECT_THAT(found->from, HasSubstr("groundtruth.txt says that it is of"));
  std::ofstream(folder + "/rgb.txt") << "# file: 'rgbd_dataset_freiburg2_desk.bag'\n";
  EXPECT_THAT(std::string(FindRgbdCalibration(query).status().message()),
              HasSubstr("say which camera it is by ?camera="));
}

TEST(RgbdCalibrationTest, KnowsThatNamedCamerasAreOf640x480) {
  RgbdCalibrationQuery query = QueryOf(MakeFolder("rgbd_dataset_freiburg1_desk"));
  query.width_px = 320;
  query.height_px = 240;
  EXPECT_THAT(std::string(FindRgbdCalibration(query).status().message()),
              HasSubstr("these intrinsics are of 640x480 pictures"));
  query.camera = "freiburg3";
  EXPECT_TRUE(absl::IsInvalidArgument(FindRgbdCalibration(query).status()));
}

TEST(RgbdCalibrationTest, OptionsGoFirst) {
  RgbdCalibrationQuery query = QueryOfFile("calibration.yaml", kRgbdYaml);
  query.camera = "icl-nuim";
  EXPECT_EQ(FindRgbdCalibration(query)->calibration.camera.fx_px, 481.2);
  query.file = WriteFile("other.txt", "530 530 320 240\n");
  EXPECT_EQ(FindRgbdCalibration(query)->calibration.camera.fx_px, 530);
  query.file = "/nowhere/calibration.yaml";
  EXPECT_TRUE(absl::IsNotFound(FindRgbdCalibration(query).status()));
}

constexpr char kKittiCalibration[] =
    "P0: 718.856 0 607.1928 0 0 718.856 185.2157 0 0 0 1 0\n"
    "P1: 718.856 0 607.1928 -386.1448 0 718.856 185.2157 0 0 0 1 0\n";

absl::StatusOr<FoundKittiCalibration> ReadKitti(const std::string& text, bool trust = false) {
  return ReadKittiCalibration({WriteFile("calib.txt", text), "P0", "P1", 1241, 376, trust});
}

TEST(KittiCalibrationTest, ReadsAGoodOne) {
  const auto found = ReadKitti(kKittiCalibration);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_NEAR(found->calibration.camera.baseline_m, 0.537166, 1e-5);
  EXPECT_EQ(found->calibration.right_cx_offset_px, 0);
  EXPECT_TRUE(found->findings.empty());
}

struct Replaced {
  std::string from, to, says;
};
class RefusedKittiTest : public ::testing::TestWithParam<Replaced> {};

TEST_P(RefusedKittiTest, IsNamed) {
  const std::string text =
      absl::StrReplaceAll(kKittiCalibration, {{GetParam().from, GetParam().to}});
  ASSERT_NE(text, kKittiCalibration);
  const absl::Status status = ReadKitti(text).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << GetParam().to << ": " << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("calib.txt"));
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedKittiTest,
    ::testing::Values(Replaced{"P1: 718.856", "P1: 600", ":2: P1 has fx 600, P0 has 718.856"},
                      Replaced{"-386.1448 0 718.856 185.2157", "-386.1448 0 718.856 180",
                               ":2: P1 has cy 180"},
                      Replaced{"-386.1448 0 718.856", "-386.1448 0 700", ":2: P1 has fy 700"},
                      Replaced{"-386.1448", "-386144.8", "a baseline of 537.166 m can't be"},
                      Replaced{"-386.1448", "386.1448", "are left and right exchanged?"},
                      Replaced{"-386.1448", "0", "must be above 0"},
                      Replaced{"P1:", "P0:", "P0 is in line 1 too"},
                      Replaced{"P1:", "P2:", "no line P1"},
                      Replaced{"-386.1448 0", "-386.1448", ":2: P1 has 11 numbers"},
                      Replaced{"-386.1448", "nan", ":2: field 4 is no number"},
                      Replaced{"0 0 1 0\nP1", "0 0 2 0\nP1", ":1: P0 is no projection"},
                      Replaced{"607.1928", "1241", "cx 1241 px of 1241 can't be"}),
    testing::NamedBy(&Replaced::says));

TEST(KittiCalibrationTest, HonoursAnotherPrincipalColumnOfTheRightCamera) {
  const auto found =
      ReadKitti(absl::StrReplaceAll(kKittiCalibration, {{"607.1928 -386", "617.4428 -386"}}));
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_NEAR(found->calibration.right_cx_offset_px, 10.25, 1e-9);
}

TEST(KittiCalibrationTest, TakesHalfSizeNumbersOnlyWhenTold) {
  const KittiCalibrationQuery half = {
      WriteFile("calib.txt", kKittiCalibration), "P0", "P1", 620, 188, false};
  EXPECT_THAT(std::string(ReadKittiCalibration(half).status().message()),
              HasSubstr("cx 607.193 px of 620 can't be: are these numbers of pictures of another "
                        "size"));
  KittiCalibrationQuery trusted = half;
  trusted.trust = true;
  EXPECT_TRUE(ReadKittiCalibration(trusted).ok());
}

}  // namespace
}  // namespace corbslam::client_agent

#include "client_agent/source/image_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace corbslam {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A fresh folder of this test's own.
std::string MakeFolder(const std::string& name) {
  const fs::path path = fs::path(::testing::TempDir()) / ("image_source_" + name);
  fs::remove_all(path);
  fs::create_directories(path);
  return path.string();
}

void WriteText(const std::string& path, const std::string& text) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path) << text;
}

void WriteImage(const std::string& path, int type, int value) {
  fs::create_directories(fs::path(path).parent_path());
  cv::imwrite(path, cv::Mat(30, 40, type, cv::Scalar::all(value)));
}

// Five frames; frame i has grey level 10 i + 10 left and 10 i + 15 right.
std::string MakeKitti(const std::string& name) {
  const std::string directory = MakeFolder(name);
  WriteText(directory + "/calib.txt",
            "P0: 50 0 20 0 0 50 15 0 0 0 1 0\nP1: 50 0 20 -25 0 50 15 0 0 0 1 0\n");
  std::string times;
  for (int i = 0; i < 5; ++i) {
    absl::StrAppend(&times, 0.1 * i, "\n");
    WriteImage(absl::StrFormat("%s/image_0/%06d.png", directory, i), CV_8UC1, 10 * i + 10);
    WriteImage(absl::StrFormat("%s/image_1/%06d.png", directory, i), CV_8UC1, 10 * i + 15);
  }
  WriteText(directory + "/times.txt", times);
  return directory;
}

// The grey levels of all frames, in the order of play.
std::vector<int> PlayGreyLevels(ImageSource& source) {
  std::vector<int> levels;
  while (true) {
    absl::StatusOr<std::optional<SensorImages>> images = source.Next();
    EXPECT_TRUE(images.ok()) << images.status();
    if (!images.ok() || !images->has_value()) return levels;
    EXPECT_EQ((*images)->timestamp_ns, source.frame(levels.size()).timestamp_ns);
    levels.push_back((*images)->grey.at<uint8_t>(3, 3));
  }
}

TEST(KittiSourceTest, ReadsCalibrationAndFrames) {
  const auto source = OpenSource("kitti:" + MakeKitti("kitti"));
  ASSERT_TRUE(source.ok()) << source.status();
  const auto& calibration = std::get<StereoCalibration>((*source)->calibration());
  EXPECT_FALSE(calibration.raw.has_value());
  EXPECT_DOUBLE_EQ(calibration.camera.fx_px, 50);
  EXPECT_DOUBLE_EQ(calibration.camera.baseline_m, 0.5);
  EXPECT_DOUBLE_EQ(calibration.camera.close_depth_m, 17.5);
  EXPECT_EQ(calibration.camera.width_px, 40);
  EXPECT_EQ((*source)->size(), 5u);
  EXPECT_EQ((*source)->frame(3).timestamp_ns, 300'000'000);
  const auto first = (*source)->Next();
  ASSERT_TRUE(first.ok() && first->has_value());
  EXPECT_EQ((*first)->grey.at<uint8_t>(0, 0), 10);
  EXPECT_EQ((*first)->right.at<uint8_t>(0, 0), 15);
  EXPECT_TRUE((*first)->depth.empty());
  EXPECT_THAT(PlayGreyLevels(*OpenSource("kitti:" + MakeKitti("kitti")).value()),
              ElementsAre(10, 20, 30, 40, 50));
}

TEST(KittiSourceTest, PlaysASelectionBackwardsWithItsOwnTimes) {
  const auto source =
      OpenSource(absl::StrCat("kitti:", MakeKitti("back"), "?frames=1:4&stride=2&reverse=1"));
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->frame(0).number, 4u);
  EXPECT_EQ((*source)->frame(1).timestamp_ns, 200'000'000);
  EXPECT_THAT(PlayGreyLevels(**source), ElementsAre(50, 30));
}

TEST(KittiSourceTest, GivesTheSameNoiseEachTime) {
  const std::string spec = absl::StrCat("kitti:", MakeKitti("noise"), "?noise=4&gamma=0.8");
  const auto a = (*OpenSource(spec))->Next();
  const auto b = (*OpenSource(spec))->Next();
  const auto other_seed = (*OpenSource(spec + "&seed=2"))->Next();
  ASSERT_TRUE(a.ok() && b.ok() && other_seed.ok());
  EXPECT_EQ(cv::norm((*a)->grey, (*b)->grey, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm((*a)->grey, (*other_seed)->grey, cv::NORM_INF), 0);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev((*a)->grey, mean, deviation);
  EXPECT_NEAR(mean[0], 255 * std::pow(10 / 255.0, 0.8), 0.6);
  EXPECT_NEAR(deviation[0], 4, 0.4);
}

TEST(KittiSourceTest, NamesTheFileThatIsBad) {
  const std::string directory = MakeKitti("bad");
  WriteText(directory + "/calib.txt", "P0: 50 0 20 0 0 50 15 0 0 0 1 0\nP1: 50 0 x\n");
  EXPECT_THAT(std::string(OpenSource("kitti:" + directory).status().message()),
              HasSubstr("calib.txt:2: P1 has 3 numbers"));
  EXPECT_EQ(OpenSource("kitti:/nowhere").status().code(), absl::StatusCode::kNotFound);
}

TEST(KittiSourceTest, TellsOfAPictureThatIsNotThereInItsTurn) {
  const std::string directory = MakeKitti("gap");
  fs::remove(directory + "/image_1/000001.png");
  const auto source = OpenSource("kitti:" + directory);
  ASSERT_TRUE(source.ok());
  EXPECT_TRUE((*source)->Next().ok());
  const absl::Status status = (*source)->Next().status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("image_1/000001.png"));
}

TEST(KittiSourceTest, RefusesASelectionOfNothing) {
  EXPECT_EQ(OpenSource(absl::StrCat("kitti:", MakeKitti("none"), "?frames=9:10")).status().code(),
            absl::StatusCode::kInvalidArgument);
}

std::string MakeTum(const std::string& name) {
  const std::string directory = MakeFolder(name);
  for (int i = 0; i < 3; ++i) {
    WriteImage(absl::StrCat(directory, "/rgb/", i, ".png"), CV_8UC3, 10 * i + 10);
    WriteImage(absl::StrCat(directory, "/depth/", i, ".png"), CV_16UC1, 5000 + i);
  }
  WriteText(directory + "/rgb.txt",
            "# time file\n1.00 rgb/0.png\n1.10 rgb/1.png\n1.20 rgb/2.png\n");
  return directory;
}

TEST(TumSourceTest, AssociatesByTime) {
  const std::string directory = MakeTum("tum_fr3_times");
  // Nearest first: 1.10 takes 1.105; 1.00 has none within 20 ms.
  WriteText(directory + "/depth.txt", "1.05 depth/0.png\n1.105 depth/1.png\n1.19 depth/2.png\n");
  const auto source = OpenSource("tum:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  ASSERT_EQ((*source)->size(), 2u);
  EXPECT_EQ((*source)->frame(0).timestamp_ns, 1'100'000'000);
  const auto first = (*source)->Next();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_EQ((*first)->grey.type(), CV_8UC1);
  EXPECT_EQ((*first)->depth.at<uint16_t>(0, 0), 5001);
  const auto& calibration = std::get<RgbdCalibration>((*source)->calibration());
  EXPECT_DOUBLE_EQ(calibration.camera.fx_px, 535.4);
  EXPECT_TRUE(calibration.distortion.IsZero());
  EXPECT_DOUBLE_EQ(calibration.camera.baseline_m, 0.08);
  EXPECT_DOUBLE_EQ(calibration.camera.close_depth_m, 3.2);
}

TEST(TumSourceTest, TakesGivenAssociationsAndCalibration) {
  const std::string directory = MakeTum("tum_given");
  WriteText(directory + "/associated.txt", "1.0 rgb/0.png 1.01 depth/2.png\n");
  WriteText(directory + "/calibration.yaml",
            "# ours\nfx: 50\nfy: 51\ncx: 20\ncy: 15\nk1: 0.1\ndepth_units_per_m: 1000\n");
  const auto source = OpenSource("tum:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  const auto& calibration = std::get<RgbdCalibration>((*source)->calibration());
  EXPECT_DOUBLE_EQ(calibration.camera.fy_px, 51);
  EXPECT_DOUBLE_EQ(calibration.distortion.k1, 0.1);
  EXPECT_DOUBLE_EQ(calibration.distortion.k2, 0);
  EXPECT_DOUBLE_EQ(calibration.depth_units_per_m, 1000);
  const auto first = (*source)->Next();
  EXPECT_EQ((*first)->depth.at<uint16_t>(0, 0), 5002);
}

TEST(TumSourceTest, NamesLineAndField) {
  const std::string directory = MakeTum("tum_bad");
  WriteText(directory + "/associated.txt", "1.0 rgb/0.png soon depth/2.png\n");
  EXPECT_THAT(std::string(OpenSource("tum:" + directory).status().message()),
              HasSubstr("associated.txt:1: field 3"));
  WriteText(directory + "/associated.txt", "1.0 rgb/0.png 1.0 rgb/1.png\n");
  const auto source = OpenSource("tum:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_THAT(std::string((*source)->Next().status().message()), HasSubstr("rgb/1.png"));
}

const char kEurocYaml[] = R"(%%YAML:1.0
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [1, 0, 0, %s,
         0, 1, 0, 0,
         0, 0, 1, 0,
         0.0, 0.0, 0.0, 1.0]
resolution: [40, 30]
camera_model: pinhole
intrinsics: [50.5, 50, 20, 15] #fu, fv, cu, cv
distortion_model: %s
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]
)";

std::string MakeEuroc(const std::string& name, const std::string& model) {
  const std::string directory = MakeFolder(name);
  for (const int camera : {0, 1}) {
    const std::string folder = absl::StrCat(directory, "/mav0/cam", camera);
    WriteText(folder + "/sensor.yaml",
              absl::StrFormat(kEurocYaml, camera == 0 ? "0" : "0.11", model));
    WriteImage(folder + "/data/1000.png", CV_8UC1, 10 + camera);
    WriteImage(folder + "/data/3000.png", CV_8UC1, 30 + camera);
    WriteText(folder + "/data.csv",
              camera == 0 ? "#timestamp [ns],filename\r\n1000,1000.png\r\n2000,2000.png\r\n"
                            "3000,3000.png\r\n"
                          : "#timestamp [ns],filename\n1000,1000.png\n3000,3000.png\n");
  }
  return directory;
}

TEST(EurocSourceTest, PairsCommonTimesAndReadsTheRawCalibration) {
  const auto source = OpenSource("euroc:" + MakeEuroc("euroc", "radial-tangential"));
  ASSERT_TRUE(source.ok()) << source.status();
  ASSERT_EQ((*source)->size(), 2u);
  EXPECT_EQ((*source)->frame(1).timestamp_ns, 3000);
  const auto& calibration = std::get<StereoCalibration>((*source)->calibration());
  ASSERT_TRUE(calibration.raw.has_value());
  EXPECT_DOUBLE_EQ(calibration.raw->left.fx_px, 50.5);
  EXPECT_DOUBLE_EQ(calibration.raw->right.distortion.p2, 1.7e-05);
  EXPECT_NEAR(calibration.raw->right_from_left.translation.x(), -0.11, 1e-12);
  EXPECT_NEAR(calibration.camera.close_depth_m, 5.5, 1e-9);
  const auto first = (*source)->Next();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_EQ((*first)->right.at<uint8_t>(0, 0), 11);
}

TEST(EurocSourceTest, RefusesAModelItDoesNotKnow) {
  EXPECT_THAT(
      std::string(OpenSource("euroc:" + MakeEuroc("fisheye", "equidistant")).status().message()),
      HasSubstr("distortion_model is 'equidistant'"));
}

// Recorded sequences: where they are (the CORBSLAM_DATA_DIR rule of the project's tests).
struct Recorded {
  const char* spec;
  size_t frames;
};

class RecordedSourceTest : public ::testing::TestWithParam<Recorded> {};

TEST_P(RecordedSourceTest, Opens) {
  const char* data = std::getenv("CORBSLAM_DATA_DIR");
  if (data == nullptr && std::getenv("CI") == nullptr) GTEST_SKIP() << "no CORBSLAM_DATA_DIR";
  ASSERT_NE(data, nullptr) << "CI runs need CORBSLAM_DATA_DIR";
  const auto [layout, folder] =
      std::pair<std::string, std::string>(absl::StrSplit(absl::string_view(GetParam().spec), ':'));
  const auto source = OpenSource(absl::StrCat(layout, ":", data, "/", folder));
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->size(), GetParam().frames);
  const auto first = (*source)->Next();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_EQ((*first)->grey.type(), CV_8UC1);
  EXPECT_NE((*first)->right.empty(), (*first)->depth.empty());
}

INSTANTIATE_TEST_SUITE_P(All, RecordedSourceTest,
                         ::testing::Values(Recorded{"kitti:kitti_00_first201", 201},
                                           Recorded{"tum:tum_fr1_xyz_15hz", 396},
                                           Recorded{"euroc:euroc_v1_01_first40", 40}));

TEST(SimulatedSourceTest, PlaysAPartAndDisturbsItsPictures) {
  const char* plain_spec = "sim:city?seed=3&length=120&picture_scale=0.1&robot=2/2&overlap=3";
  auto plain = OpenSource(plain_spec);
  ASSERT_TRUE(plain.ok()) << plain.status();
  auto noisy = OpenSource(absl::StrCat(plain_spec, "&gamma=0.5&threads=2"));
  ASSERT_TRUE(noisy.ok()) << noisy.status();
  const size_t frames = (*OpenSource("sim:city?seed=3&length=120"))->size();
  EXPECT_EQ((*plain)->size(), frames - frames / 2 + 3);
  EXPECT_EQ((*plain)->frame(0).number, frames / 2 - 3);
  const SensorImages first = **(*plain)->Next();
  EXPECT_EQ(first.timestamp_ns, (*plain)->frame(0).timestamp_ns);
  EXPECT_EQ(first.grey.size(), first.right.size());
  const SensorImages brighter = **(*noisy)->Next();
  EXPECT_GT(cv::mean(brighter.grey)[0], cv::mean(first.grey)[0] + 10);
}

TEST(SimulatedSourceTest, NamesAFileThatIsNotThere) {
  EXPECT_EQ(OpenSource("sim:path?poses=/nowhere/00.txt").status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace corbslam

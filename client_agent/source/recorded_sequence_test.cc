#include "client_agent/source/recorded_sequence.h"

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
#include "slam/util/testing/case_name.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Makes a fresh folder of this test's own.
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

// Writes five frames; frame i has grey level 10 i + 10 left and 10 i + 15 right.
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

// Returns the grey levels of all frames, in the order of play.
std::vector<int> PlayGreyLevels(RecordedSequence& source) {
  std::vector<int> levels;
  while (true) {
    absl::StatusOr<std::optional<SensorImages>> images = source.NextImages();
    EXPECT_TRUE(images.ok()) << images.status();
    if (!images.ok() || !images->has_value()) return levels;
    EXPECT_EQ((*images)->timestamp_ns, source.frame(levels.size()).timestamp_ns);
    levels.push_back((*images)->grey.at<uint8_t>(3, 3));
  }
}

std::vector<std::string> CodesOf(const SourceFindings& findings) {
  std::vector<std::string> codes;
  for (const SourceFinding& finding : findings) codes.push_back(finding.code);
  return codes;
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
  const auto first = (*source)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value());
  EXPECT_EQ((*first)->grey.at<uint8_t>(0, 0), 10);
  EXPECT_EQ((*first)->right.at<uint8_t>(0, 0), 15);
  EXPECT_TRUE((*first)->depth.empty());
  EXPECT_THAT(PlayGreyLevels(*OpenSource("kitti:" + MakeKitti("kitti")).value()),
              ElementsAre(10, 20, 30, 40, 50));
}

// Whatever lies beside the pictures of the first camera is not looked at.
TEST(KittiSourceTest, PlaysOneCameraAlone) {
  const std::string directory = MakeKitti("one");
  std::filesystem::remove_all(directory + "/image_1");
  EXPECT_FALSE(OpenSource("kitti:" + directory).ok());
  const auto source = OpenSource("kitti:" + directory + "?cameras=1");
  ASSERT_TRUE(source.ok()) << source.status();
  const auto& calibration = std::get<MonocularCalibration>((*source)->calibration());
  EXPECT_DOUBLE_EQ(calibration.camera.fx_px, 50);
  EXPECT_FALSE(calibration.camera.IsMetric());
  EXPECT_EQ((*source)->size(), 5u);
  const auto first = (*source)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value());
  EXPECT_EQ((*first)->grey.at<uint8_t>(0, 0), 10);
  EXPECT_TRUE((*first)->right.empty());
  EXPECT_TRUE((*first)->depth.empty());
  EXPECT_THAT(std::string(OpenSource("kitti:" + directory + "?cameras=3").status().message()),
              HasSubstr("cameras=3"));
  EXPECT_EQ(FormatSourceSpec(*ParseSourceSpec("kitti:" + directory + "?cameras=1")),
            "kitti:" + directory + "?cameras=1");
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
  const auto a = (*OpenSource(spec))->NextImages();
  const auto b = (*OpenSource(spec))->NextImages();
  const auto other_seed = (*OpenSource(spec + "&seed=2"))->NextImages();
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

std::vector<size_t> PlayNumbers(RecordedSequence& source) {
  std::vector<size_t> numbers;
  while (true) {
    const absl::StatusOr<NextFrame> next = source.Next(absl::InfinitePast());
    EXPECT_TRUE(next.ok()) << next.status();
    if (!next.ok() || std::holds_alternative<StreamEnd>(*next)) return numbers;
    const StreamFrame& played = std::get<StreamFrame>(*next);
    EXPECT_EQ(played.images.timestamp_ns, played.frame.timestamp_ns);
    numbers.push_back(played.frame.number);
  }
}

TEST(KittiSourceTest, LeavesOutAPictureThatIsNotThereOrCannotBeRead) {
  const std::string directory = MakeKitti("gap");
  fs::remove(directory + "/image_1/000001.png");
  WriteText(directory + "/image_0/000003.png", "");
  const auto source = OpenSource("kitti:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_THAT(PlayNumbers(**source), ElementsAre(0, 2, 4));
  EXPECT_EQ((*source)->left_out().count, 2u);
  EXPECT_THAT((*source)->left_out().last, HasSubstr("image_0/000003.png"));
}

TEST(KittiSourceTest, SaysAtOnceWhichPictureIsNotThere) {
  const std::string directory = MakeKitti("missing");
  fs::remove(directory + "/image_1/000001.png");
  const auto reader = OpenReader(*ParseSourceSpec("kitti:" + directory));
  ASSERT_TRUE(reader.ok()) << reader.status();
  const SourceRemarks& remarks = (*reader)->description().remarks;
  EXPECT_THAT(CodesOf(remarks.findings), ElementsAre("pictures-missing"));
  EXPECT_THAT(remarks.left_out, ElementsAre(HasSubstr("image_1/000001.png")));
}

TEST(KittiSourceTest, EndsAfterTooManyUnreadablePicturesInARow) {
  const std::string directory = MakeKitti("broken");
  std::string times;
  for (size_t i = 0; i < 30; ++i) {
    absl::StrAppend(&times, 0.1 * static_cast<double>(i), "\n");
    for (const int camera : {0, 1}) {
      const std::string path = absl::StrFormat("%s/image_%d/%06d.png", directory, camera, i);
      WriteImage(path, CV_8UC1, 50);
      if (i >= 12 && i < 12 + kMaxUnreadableInARow) WriteText(path, "no picture");
    }
  }
  WriteText(directory + "/times.txt", times);
  const auto source = OpenSource("kitti:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  for (size_t i = 0; i < 12; ++i) ASSERT_TRUE((*source)->NextImages().ok()) << i;
  const absl::Status status = (*source)->NextImages().status();
  EXPECT_THAT(std::string(status.message()), HasSubstr("10 frames in a row can't be read"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("image_0/000021.png"));
  const auto after = (*source)->NextImages();
  EXPECT_TRUE(after.ok() && !after->has_value());
}

TEST(KittiSourceTest, ReadsColourJpegAndTimesFromARate) {
  const std::string directory = MakeFolder("colour");
  WriteText(directory + "/calib.txt",
            "\xef\xbb\xbfP2: 50 0 20 0 0 50 15 0 0 0 1 0\r\n"
            "P3: 50\t0 20 -25 0 50 15 0 0 0 1 0 # right\r\n");
  for (int i = 0; i < 3; ++i) {
    WriteImage(absl::StrFormat("%s/image_2/%06d.jpg", directory, i), CV_8UC3, 100);
    WriteImage(absl::StrFormat("%s/image_3/%06d.jpg", directory, i), CV_8UC3, 100);
  }
  const absl::Status no_times = OpenSource("kitti:" + directory).status();
  EXPECT_THAT(std::string(no_times.message()), HasSubstr("say ?fps=RATE"));
  const auto source = OpenSource("kitti:" + directory + "?fps=20");
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->size(), 3u);
  EXPECT_EQ((*source)->frame(2).timestamp_ns, 100'000'000);
}

TEST(KittiSourceTest, ReadsRawRecordings) {
  const std::string directory = MakeFolder("raw") + "/2011_09_26_drive_0001_sync";
  WriteText(directory + "/../calib_cam_to_cam.txt",
            "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.950000e-02\n"
            "P_rect_00: 50 0 20 0 0 50 15 0 0 0 1 0\nP_rect_01: 50 0 20 -25 0 50 15 0 0 0 1 0\n");
  for (const char* camera : {"image_00", "image_01"}) {
    for (int i = 0; i < 2; ++i) {
      WriteImage(absl::StrFormat("%s/%s/data/%010d.png", directory, camera, i), CV_8UC1, 100);
    }
    WriteText(absl::StrCat(directory, "/", camera, "/timestamps.txt"),
              "2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.067787744\n");
  }
  const auto source = OpenSource("kitti:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->frame(0).timestamp_ns, 1317042145964389445);
  EXPECT_EQ((*source)->frame(1).timestamp_ns, 1317042146067787744);
}

TEST(KittiSourceTest, TellsTimesThatDoNotFitThePictures) {
  const std::string directory = MakeKitti("few");
  WriteText(directory + "/times.txt", "0\n0.1\n0.2\n");
  EXPECT_THAT(std::string(OpenSource("kitti:" + directory).status().message()),
              HasSubstr("times.txt: 3 times, but pictures are numbered up to 4"));
  WriteText(directory + "/times.txt", "0\n0.1\n0.2\n0.3\n0.4\n0.5\n0.6\n");
  const auto reader = OpenReader(*ParseSourceSpec("kitti:" + directory));
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ((*reader)->frame_count(), 5u);
  EXPECT_THAT((*reader)->description().remarks.left_out,
              ElementsAre(HasSubstr("the last 2 times")));
}

TEST(KittiSourceTest, NamesAPictureOfAnotherSize) {
  const std::string directory = MakeKitti("size");
  cv::imwrite(directory + "/image_1/000002.png", cv::Mat(20, 40, CV_8UC1, cv::Scalar(7)));
  const auto source = OpenSource("kitti:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_THAT(PlayNumbers(**source), ElementsAre(0, 1, 3, 4));
  EXPECT_THAT((*source)->left_out().last,
              HasSubstr("image_1/000002.png: 40x20 pixels, the calibration is of 40x30"));
}

TEST(KittiSourceTest, BeginsAnotherDriveWhereTimeJumpsBack) {
  const std::string directory = MakeKitti("twice");
  WriteText(directory + "/times.txt", "10\n10.1\n10.2\n0.1\n0.2\n");
  const auto source = OpenSource("kitti:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->frame(2).drive, 0);
  EXPECT_EQ((*source)->frame(3).drive, 1);
}

TEST(SourceSpecTest, TakesAFolderWithAQuestionMarkInItsName) {
  const std::string directory = MakeFolder("what") + "/really?";
  fs::rename(MakeKitti("really"), directory);
  for (const char* options : {"", "?frames=1:3"}) {
    const auto source = OpenSource(absl::StrCat("kitti:", directory, options));
    ASSERT_TRUE(source.ok()) << source.status();
    EXPECT_EQ((*source)->size(), *options == 0 ? 5u : 3u);
  }
  const auto spec = ParseSourceSpec("kitti:" + directory);
  EXPECT_EQ(ParseSourceSpec(FormatSourceSpec(*spec))->directory, directory);
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
  WriteText(directory + "/calibration.yaml", "fx: 50\nfy: 50\ncx: 20\ncy: 15\n");
  WriteText(directory + "/rgb.txt",
            "# time file\n1.00 rgb/0.png\n1.10 rgb/1.png\n1.20 rgb/2.png\n");
  return directory;
}

TEST(TumSourceTest, AssociatesByTime) {
  const std::string directory = MakeTum("tum_fr3_times");
  // The nearest pair is taken first: 1.10 takes 1.105; 1.00 has none within 20 ms.
  WriteText(directory + "/depth.txt", "1.05 depth/0.png\n1.105 depth/1.png\n1.19 depth/2.png\n");
  const auto source = OpenSource("tum:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  ASSERT_EQ((*source)->size(), 2u);
  EXPECT_EQ((*source)->frame(0).timestamp_ns, 1'100'000'000);
  const auto first = (*source)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_EQ((*first)->grey.type(), CV_8UC1);
  EXPECT_EQ((*first)->depth.at<uint16_t>(0, 0), 5001);
  const auto& calibration = std::get<RgbdCalibration>((*source)->calibration());
  EXPECT_DOUBLE_EQ(calibration.camera.fx_px, 50);
  EXPECT_TRUE(std::get<RadialTangential>(calibration.lens).IsZero());
  EXPECT_DOUBLE_EQ(calibration.camera.baseline_m, 0.08);
  EXPECT_DOUBLE_EQ(calibration.camera.close_depth_m, 3.2);
}

TEST(TumSourceTest, PlaysOneCameraAloneWithPicturesThatHaveNoDepth) {
  const std::string directory = MakeTum("tum_one");
  std::filesystem::remove_all(directory + "/depth");
  const auto source = OpenSource("tum:" + directory + "?cameras=1");
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->size(), 3u);
  EXPECT_EQ((*source)->frame(2).timestamp_ns, 1'200'000'000);
  const auto& calibration = std::get<MonocularCalibration>((*source)->calibration());
  EXPECT_DOUBLE_EQ(calibration.camera.cx_px, 20);
  const auto first = (*source)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_TRUE((*first)->depth.empty());
  // Where they come with an association, its pictures are taken.
  std::filesystem::remove(directory + "/rgb.txt");
  WriteText(directory + "/associated.txt", "1.0 rgb/0.png 1.01 depth/2.png\n");
  const auto associated = OpenSource("tum:" + directory + "?cameras=1");
  ASSERT_TRUE(associated.ok()) << associated.status();
  EXPECT_EQ((*associated)->size(), 1u);
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
  EXPECT_DOUBLE_EQ(std::get<RadialTangential>(calibration.lens).k1, 0.1);
  EXPECT_DOUBLE_EQ(std::get<RadialTangential>(calibration.lens).k2, 0);
  EXPECT_DOUBLE_EQ(calibration.depth_units_per_m, 1000);
  const auto first = (*source)->NextImages();
  EXPECT_EQ((*first)->depth.at<uint16_t>(0, 0), 5002);
}

TEST(TumSourceTest, NamesLineAndField) {
  const std::string directory = MakeTum("tum_bad");
  WriteText(directory + "/associated.txt", "1.0 rgb/0.png soon depth/2.png\n");
  EXPECT_THAT(std::string(OpenSource("tum:" + directory).status().message()),
              HasSubstr("associated.txt:1: field 3"));
  WriteText(directory + "/associated.txt", "1.0 rgb/0.png 1.0 rgb/1.png\n");
  EXPECT_THAT(std::string(OpenSource("tum:" + directory).status().message()),
              HasSubstr("which is the depth image, "));
}

TEST(TumSourceTest, LeavesOutADepthImageThatIsNone) {
  const std::string directory = MakeTum("tum_depth");
  WriteImage(directory + "/depth/1.png", CV_8UC1, 7);
  WriteText(directory + "/associated.txt",
            "1.0 rgb/0.png 1.0 depth/0.png\n1.1 rgb/1.png 1.1 depth/1.png\n"
            "1.2 rgb/2.png 1.2 depth/2.png\n");
  const auto source = OpenSource("tum:" + directory);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_THAT(PlayNumbers(**source), ElementsAre(0, 2));
  EXPECT_THAT((*source)->left_out().last, HasSubstr("depth/1.png"));
}

TEST(TumSourceTest, FindsTheCalibrationBesideThePicturesThatAFolderOfLinksShows) {
  const std::string recording = MakeTum("tum_recording");
  const std::string links = MakeFolder("tum_links");
  for (const char* name : {"rgb", "depth"}) {
    fs::create_directory_symlink(absl::StrCat(recording, "/", name),
                                 absl::StrCat(links, "/", name));
  }
  WriteText(links + "/associated.txt", "1.0 rgb/0.png 1.01 depth/2.png\n");
  const auto source = OpenSource("tum:" + links);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_DOUBLE_EQ(std::get<RgbdCalibration>((*source)->calibration()).camera.fx_px, 50);
}

TEST(TumSourceTest, TakesAssociationsEitherWayRound) {
  for (const char* name : {"associated.txt", "associations.txt", "association.txt"}) {
    const std::string directory = MakeTum("tum_turned");
    WriteText(absl::StrCat(directory, "/", name), "1.0 depth/2.png 1.01 rgb/1.png\r\n");
    const auto source = OpenSource("tum:" + directory);
    ASSERT_TRUE(source.ok()) << source.status();
    EXPECT_EQ((*source)->frame(0).timestamp_ns, 1'010'000'000);
    const auto first = (*source)->NextImages();
    ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
    EXPECT_EQ((*first)->depth.at<uint16_t>(0, 0), 5002);
  }
}

TEST(TumSourceTest, LeavesOutPairsThatAreFarApartInTime) {
  const std::string directory = MakeTum("tum_far");
  WriteText(directory + "/associated.txt",
            "1.0 rgb/0.png 1.01 depth/0.png\n1.1 rgb/1.png 2.1 depth/1.png\n");
  const auto reader = OpenReader(*ParseSourceSpec("tum:" + directory));
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ((*reader)->frame_count(), 1u);
  EXPECT_THAT(CodesOf((*reader)->description().remarks.findings), ElementsAre("pairs-far-apart"));
  WriteText(directory + "/associated.txt", "1.0 rgb/0.png 5.0 depth/0.png\n");
  EXPECT_THAT(
      std::string(OpenSource("tum:" + directory).status().message()),
      HasSubstr("associated.txt:1: the picture is of 1.000000000 s, its depth image of 5."));
}

TEST(TumSourceTest, SaysWhichFilesItLooksFor) {
  const absl::Status status = OpenSource("tum:" + MakeFolder("nothing")).status();
  EXPECT_TRUE(absl::IsNotFound(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("neither associated.txt"));
}

TEST(TumSourceTest, ScalesPicturesOf12BitsIn16) {
  const std::string directory = MakeTum("tum_12bit");
  std::string lines;
  for (int i = 0; i < 3; ++i) {
    cv::Mat grey(30, 40, CV_16UC1, cv::Scalar(1600));
    grey.colRange(0, 20).setTo(3900);
    cv::imwrite(absl::StrCat(directory, "/rgb/", i, ".png"), grey);
    absl::StrAppend(&lines, "1.", i, " rgb/", i, ".png 1.", i, " depth/", i, ".png\n");
  }
  WriteText(directory + "/associated.txt", lines);
  const auto reader = OpenReader(*ParseSourceSpec("tum:" + directory));
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ((*reader)->description().remarks.findings.size(), 1u);
  const auto first = (*reader)->Read(0);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->grey.type(), CV_8UC1);
  EXPECT_EQ(first->grey.at<uint8_t>(5, 30), 100);
  EXPECT_EQ(first->grey.at<uint8_t>(5, 5), 243);
}

TEST(SevenScenesSourceTest, ReadsItsFilesWithAStatedRateAndCalibration) {
  const std::string directory = MakeFolder("seven");
  for (int i = 0; i < 3; ++i) {
    WriteImage(absl::StrFormat("%s/frame-%06d.color.png", directory, i), CV_8UC3, 10 * i + 10);
    WriteImage(absl::StrFormat("%s/frame-%06d.depth.png", directory, i), CV_16UC1, 1000 + i);
  }
  EXPECT_THAT(std::string(OpenSource("7scenes:" + directory).status().message()),
              HasSubstr("?fps=RATE"));
  EXPECT_THAT(std::string(OpenSource("7scenes:" + directory + "?fps=30").status().message()),
              HasSubstr("no calibration"));
  WriteText(directory + "/k.yaml", "fx: 50\nfy: 50\ncx: 20\ncy: 15\ndepth_units_per_m: 1000\n");
  const auto source =
      OpenSource(absl::StrCat("7scenes:", directory, "?fps=30&calibration=", directory, "/k.yaml"));
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->frame(1).timestamp_ns, 33'333'333);
  EXPECT_EQ((**(*source)->NextImages()).depth.at<uint16_t>(0, 0), 1000);
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
              camera == 0
                  ? "#timestamp [ns],filename\r\n100000000,1000.png\r\n200000000,2000.png\r\n"
                    "300000000,3000.png\r\n"
                  : "#timestamp [ns],filename\n100000000,1000.png\n300000000,3000.png\n");
  }
  return directory;
}

TEST(EurocSourceTest, PairsCommonTimesAndReadsTheRawCalibration) {
  const auto source = OpenSource("euroc:" + MakeEuroc("euroc", "radial-tangential"));
  ASSERT_TRUE(source.ok()) << source.status();
  ASSERT_EQ((*source)->size(), 2u);
  EXPECT_EQ((*source)->frame(1).timestamp_ns, 300'000'000);
  const auto& calibration = std::get<StereoCalibration>((*source)->calibration());
  ASSERT_TRUE(calibration.raw.has_value());
  EXPECT_DOUBLE_EQ(calibration.raw->left.fx_px, 50.5);
  EXPECT_DOUBLE_EQ(std::get<RadialTangential>(calibration.raw->right.lens).p2, 1.7e-05);
  EXPECT_NEAR(calibration.raw->right_from_left.translation.x(), -0.11, 1e-12);
  EXPECT_NEAR(calibration.camera.close_depth_m, 5.5, 1e-9);
  const auto first = (*source)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_EQ((*first)->right.at<uint8_t>(0, 0), 11);
}

TEST(EurocSourceTest, PlaysOneCameraAloneThroughItsLens) {
  const std::string directory = MakeEuroc("euroc_one", "radial-tangential");
  std::filesystem::remove_all(directory + "/mav0/cam1");
  WriteImage(directory + "/mav0/cam0/data/2000.png", CV_8UC1, 20);
  const auto source = OpenSource("euroc:" + directory + "?cameras=1");
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->size(), 3u) << "also pictures without a counterpart";
  const auto& calibration = std::get<MonocularCalibration>((*source)->calibration());
  EXPECT_DOUBLE_EQ(calibration.camera.fx_px, 50.5);
  EXPECT_FALSE(std::get<RadialTangential>(calibration.lens).IsZero());
  EXPECT_TRUE(calibration.body_from_raw.has_value());
  EXPECT_TRUE(MakeSensor(calibration, {}).ok());
}

TEST(EurocSourceTest, PairsWhatIsNearlyOfOneTime) {
  const std::string directory = MakeEuroc("euroc_near", "radtan");
  WriteText(directory + "/mav0/cam1/data.csv",
            "timestamp,filename\n1300,1000.png\n2999700,3000.png\n");
  WriteText(directory + "/mav0/cam0/data.csv",
            "timestamp [ns],filename\n1000, 1000.png\n3000000,3000.png\n");
  auto reader = OpenReader(*ParseSourceSpec("euroc:" + directory));
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ((*reader)->frame_count(), 2u);
  EXPECT_EQ((*reader)->timestamp_ns(1), 3'000'000);
  EXPECT_THAT((*reader)->description().remarks.findings, ::testing::IsEmpty());
  reader = OpenReader(*ParseSourceSpec("euroc:" + directory + "?pair-within-ms=0"));
  EXPECT_THAT(std::string(reader.status().message()), HasSubstr("have no common times"));
}

// The right camera stamps its pictures 40 ms early.
TEST(EurocSourceTest, ARigSaysByHowMuchTimesDiffer) {
  const std::string directory = MakeEuroc("euroc_offset", "radtan");
  WriteText(directory + "/mav0/cam1/data.csv", "60000000,1000.png\n260000000,3000.png\n");
  const std::string rig = directory + "/rig.yaml";
  const auto open = [&](const std::string& offset) {
    WriteText(rig, absl::StrCat("rig: 1\nkind: stereo\nrectified: true\nbaseline_m: 0.11\n",
                                "cameras:\n  - {size_px: [40, 30], focal_px: [50, 50], ",
                                "principal_px: [20, 15]}\n  - {size_px: [40, 30], ",
                                "focal_px: [50, 50], principal_px: [20, 15]", offset, "}\n"));
    return OpenReader(*ParseSourceSpec(absl::StrCat("euroc:", directory, "?rig=", rig)));
  };
  EXPECT_THAT(std::string(open("").status().message()), HasSubstr("have no common times"));
  const auto reader = open(", time_offset_s: 0.04");
  ASSERT_TRUE(reader.ok()) << reader.status();
  ASSERT_EQ((*reader)->frame_count(), 2u);
  EXPECT_EQ((*reader)->timestamp_ns(1), 300'000'000);
  EXPECT_EQ((*reader)->Read(1)->right.at<uint8_t>(0, 0), 31);
}

TEST(EurocSourceTest, CountsWhatHasNoCounterpart) {
  const std::string directory = MakeEuroc("euroc_odd", "radtan");
  std::string left;
  for (int i = 0; i < 5; ++i) absl::StrAppend(&left, 50'000'000 * int64_t{i}, ",1000.png\n");
  WriteText(directory + "/mav0/cam0/data.csv", left);
  WriteText(directory + "/mav0/cam1/data.csv",
            "0,1000.png\n50000000,3000.png\n70000000,3000.png\n");
  const auto reader = OpenReader(*ParseSourceSpec("euroc:" + directory));
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ((*reader)->frame_count(), 2u);
  EXPECT_THAT((*reader)->description().remarks.left_out,
              ElementsAre(HasSubstr("3 of 5 pictures of cam0 and 1 of 3 of cam1")));
}

struct BadList {
  const char* name;
  const char* text;
  const char* says;
};
class BadCameraListTest : public ::testing::TestWithParam<BadList> {};

TEST_P(BadCameraListTest, IsNamedByLine) {
  const std::string directory =
      MakeEuroc(absl::StrCat("euroc_list_", GetParam().name), "radial-tangential");
  WriteText(directory + "/mav0/cam0/data.csv", GetParam().text);
  EXPECT_THAT(std::string(OpenSource("euroc:" + directory).status().message()),
              HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadCameraListTest,
    ::testing::Values(
        BadList{"twice", "1000,1000.png\n3000,3000.png\n3000,1000.png\n",
                "data.csv:3: the time 3000 stands in line 2 too"},
        BadList{"negative", "-1000,1000.png\n", "data.csv:1: the time -1000 is negative"},
        BadList{"seconds", "#t,f\n1.5,1000.png\n", "data.csv:2: field 1 is no time in whole"},
        BadList{"no_file", "1000\n", "data.csv:1: field 2 names no file"},
        BadList{"empty", "#t,f\n", "cam0/data.csv: lists no picture"},
        BadList{"other_time", "1403715273000000000,1000.png\n", "have no common times: cam0 lists"},
        BadList{"utf16",
                "\xff\xfe"
                "1,a",
                "data.csv:1: is UTF-16 text"}),
    testing::NamedBy(&BadList::name));

TEST(EurocSourceTest, RefusesAModelItDoesNotKnow) {
  EXPECT_THAT(
      std::string(OpenSource("euroc:" + MakeEuroc("unknown_lens", "fov")).status().message()),
      HasSubstr("distortion_model is 'fov'"));
}

// A recorded sequence; CORBSLAM_DATA_DIR says where these are, as in all of the project's tests.
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
  const auto first = (*source)->NextImages();
  ASSERT_TRUE(first.ok() && first->has_value()) << first.status();
  EXPECT_EQ((*first)->grey.type(), CV_8UC1);
  EXPECT_NE((*first)->right.empty(), (*first)->depth.empty());
}

INSTANTIATE_TEST_SUITE_P(All, RecordedSourceTest,
                         ::testing::Values(Recorded{"kitti:kitti_00_first201", 201},
                                           Recorded{"tum:tum_fr1_xyz_15hz", 396},
                                           Recorded{"euroc:euroc_v1_01_first40", 40}),
                         testing::NamedBy(&Recorded::spec));

}  // namespace
}  // namespace corbslam::client_agent

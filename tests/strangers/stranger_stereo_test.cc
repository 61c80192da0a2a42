// Tests what corbslam doctor --source says of stereo recordings as strangers bring them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "services/tool/doctor/local_checks.h"
#include "slam/util/testing/case_name.h"
#include "tests/strangers/strange_recordings.h"

namespace corbslam::tests {

using client_agent::SourceLayout;
using services::CheckSource;
using services::Finding;
using services::Findings;
using services::FormatFindings;
using services::Level;
using services::ToString;

namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

using Change = std::function<void(const std::string&)>;

struct Stranger {
  const char* name;
  Change change;     // Changes a sound recording in this folder.
  Level level;       // Level of the worst finding.
  const char* says;  // Text in one of the findings of that level.
  const char* options = "";
};

void PrintTo(const Stranger& stranger, std::ostream* out) { *out << stranger.name; }

void Expect(const Stranger& stranger, const std::string& spec) {
  const Findings findings = CheckSource(spec + stranger.options, false);
  Level worst = Level::kOk;
  std::vector<std::string> texts;
  for (const Finding& finding : findings) worst = std::max(worst, finding.level);
  for (const Finding& finding : findings) {
    if (finding.level == worst) texts.push_back(absl::StrCat(finding.text, "|", finding.advice));
  }
  EXPECT_EQ(ToString(worst), ToString(stranger.level)) << FormatFindings(findings);
  EXPECT_THAT(texts, Contains(HasSubstr(stranger.says)));
}

void Exchange(const std::string& folder, const char* a, const char* b) {
  fs::rename(folder + a, folder + "/aside");
  fs::rename(folder + b, folder + a);
  fs::rename(folder + "/aside", folder + b);
}

// Sets number `index` of the twelve of row P1.
Change SetRightProjection(size_t index, const std::function<double(double)>& change) {
  return [=](const std::string& folder) {
    std::vector<std::string> lines = ReadAllLines(folder + "/calib.txt");
    std::vector<std::string> fields = absl::StrSplit(lines[1], ' ');
    fields[index + 1] = absl::StrCat(change(std::stod(fields[index + 1])));
    lines[1] = absl::StrJoin(fields, " ");
    WriteAllLines(folder + "/calib.txt", lines);
  };
}

Change ChangeRight(const std::function<cv::Mat(const cv::Mat&)>& change) {
  return [=](const std::string& folder) {
    ChangePictures(folder, "image_1", cv::IMREAD_UNCHANGED, change);
  };
}

cv::Mat Moved(const cv::Mat& image, double x_px, double y_px) {
  cv::Mat moved;
  const cv::Matx23d shift(1, 0, x_px, 0, 1, y_px);
  cv::warpAffine(image, moved, shift, image.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return moved;
}

// Makes the right picture the one of a frame later.
void MakeRightLate(const std::string& folder) {
  std::vector<std::string> files = FilesOf(folder + "/image_1");
  for (size_t i = 0; i + 1 < files.size(); ++i) fs::rename(files[i + 1], files[i]);
  const std::string last = FilesOf(folder + "/image_0").back();
  fs::remove(last);
  std::vector<std::string> times = ReadAllLines(folder + "/times.txt");
  times.pop_back();
  WriteAllLines(folder + "/times.txt", times);
}

void Cut(const std::string& folder, const char* list, size_t lines_left) {
  std::vector<std::string> lines = ReadAllLines(folder + list);
  lines.resize(lines_left);
  WriteAllLines(folder + list, lines);
}

class StrangerKittiTest : public ::testing::TestWithParam<Stranger> {};

TEST_P(StrangerKittiTest, IsTakenRightlyOrNamed) {
  const std::string folder = CopyStereo(SourceLayout::kKitti, GetParam().name);
  GetParam().change(folder);
  Expect(GetParam(), "kitti:" + folder);
}

INSTANTIATE_TEST_SUITE_P(
    Files, StrangerKittiTest,
    ::testing::Values(
        Stranger{"as_it_is", [](const std::string&) {}, Level::kOk, "baseline: "},
        Stranger{"fewer_times", [](const std::string& f) { Cut(f, "/times.txt", 6); }, Level::kFail,
                 "times.txt: 6 times, but pictures are numbered up to"},
        Stranger{"no_times", [](const std::string& f) { fs::remove(f + "/times.txt"); },
                 Level::kFail, "say ?fps=RATE"},
        Stranger{"times_from_a_rate", [](const std::string& f) { fs::remove(f + "/times.txt"); },
                 Level::kOk, "from ?fps=10", "?fps=10"},
        Stranger{"one_row", [](const std::string& f) { Cut(f, "/calib.txt", 1); }, Level::kFail,
                 "no line P1"},
        Stranger{"no_calibration", [](const std::string& f) { fs::remove(f + "/calib.txt"); },
                 Level::kFail, "calib.txt"},
        Stranger{"colour_folders_only",
                 [](const std::string& f) {
                   fs::rename(f + "/image_0", f + "/image_2");
                   fs::rename(f + "/image_1", f + "/image_3");
                 },
                 Level::kFail, "no line P2"},
        Stranger{"right_missing", [](const std::string& f) { fs::remove_all(f + "/image_1"); },
                 Level::kFail, "no pictures of a stereo pair"},
        Stranger{"half_of_right_missing",
                 [](const std::string& f) {
                   const std::vector<std::string> files = FilesOf(f + "/image_1");
                   for (size_t i = 1; i < files.size(); i += 3) fs::remove(files[i]);
                 },
                 Level::kWarn, "pictures-missing"}),
    testing::NamedBy(&Stranger::name));

INSTANTIATE_TEST_SUITE_P(
    Calibrations, StrangerKittiTest,
    ::testing::Values(
        Stranger{"another_focal_length", SetRightProjection(0, [](double) { return 300; }),
                 Level::kFail, "P1 has fx 300"},
        Stranger{"another_row", SetRightProjection(6, [](double cy) { return cy + 3; }),
                 Level::kFail, "P1 has cy"},
        Stranger{"baseline_in_mm", SetRightProjection(3, [](double t) { return 1000 * t; }),
                 Level::kFail, "is it in metres?"},
        Stranger{"baseline_turned", SetRightProjection(3, [](double t) { return -t; }),
                 Level::kFail, "are left and right exchanged?"},
        Stranger{"half_size",
                 [](const std::string& f) {
                   for (const char* folder : {"image_0", "image_1"}) {
                     ChangePictures(f, folder, cv::IMREAD_UNCHANGED, [](const cv::Mat& image) {
                       cv::Mat half;
                       cv::resize(image, half, {}, 0.5, 0.5, cv::INTER_AREA);
                       return half;
                     });
                   }
                 },
                 Level::kFail, "are these numbers of pictures of another size"}),
    testing::NamedBy(&Stranger::name));

INSTANTIATE_TEST_SUITE_P(
    Pairs, StrangerKittiTest,
    ::testing::Values(
        Stranger{"exchanged", [](const std::string& f) { Exchange(f, "/image_0", "/image_1"); },
                 Level::kFail, "pair-exchanged"},
        Stranger{"same_picture",
                 [](const std::string& f) {
                   fs::remove_all(f + "/image_1");
                   fs::copy(f + "/image_0", f + "/image_1",
                            fs::copy_options::recursive | fs::copy_options::copy_symlinks);
                 },
                 Level::kFail, "pair-same-picture"},
        Stranger{"rows_apart", ChangeRight([](const cv::Mat& image) { return Moved(image, 0, 6); }),
                 Level::kFail, "pair-rows-apart"},
        Stranger{"right_late", MakeRightLate, Level::kFail, "pair-late"},
        Stranger{"right_of_another_size", ChangeRight([](const cv::Mat& image) {
                   return cv::Mat(image, cv::Rect(0, 0, image.cols - 8, image.rows)).clone();
                 }),
                 Level::kFail, "pixels, the calibration is of"},
        Stranger{"right_black", ChangeRight([](const cv::Mat& image) {
                   return cv::Mat(cv::Mat::zeros(image.size(), image.type()));
                 }),
                 Level::kFail, ""}),
    testing::NamedBy(&Stranger::name));

class StrangerEurocTest : public ::testing::TestWithParam<Stranger> {};

TEST_P(StrangerEurocTest, IsTakenRightlyOrNamed) {
  const std::string folder = CopyStereo(SourceLayout::kEuroc, GetParam().name);
  GetParam().change(folder);
  Expect(GetParam(), "euroc:" + folder);
}

// Gives the picture of line i another time in nanoseconds.
Change RetimeRight(const std::function<int64_t(size_t, int64_t)>& retime) {
  return [=](const std::string& folder) {
    const std::string list = folder + "/mav0/cam1/data.csv";
    std::vector<std::string> lines = ReadAllLines(list);
    for (size_t i = 1; i < lines.size(); ++i) {
      const std::vector<std::string> fields = absl::StrSplit(lines[i], ',');
      lines[i] = absl::StrCat(retime(i, std::stoll(fields[0])), ",", fields[1]);
    }
    WriteAllLines(list, lines);
  };
}

INSTANTIATE_TEST_SUITE_P(
    All, StrangerEurocTest,
    ::testing::Values(
        Stranger{"as_it_is", [](const std::string&) {}, Level::kOk, "baseline: "},
        Stranger{"nearly_of_one_time", RetimeRight([](size_t i, int64_t time_ns) {
                   return time_ns + (i % 2 == 0 ? 300 : 0);
                 }),
                 Level::kOk, "layout: EuRoC"},
        Stranger{"of_another_hour",
                 RetimeRight([](size_t, int64_t time_ns) { return time_ns + 3'600'000'000'000; }),
                 Level::kFail, "cam0 and cam1 have no common times"},
        Stranger{"time_twice",
                 RetimeRight([](size_t i, int64_t time_ns) { return i == 3 ? 0 : time_ns; }),
                 Level::kFail, "stands in line 2 too"},
        Stranger{"every_third_missing",
                 [](const std::string& f) {
                   const std::string list = f + "/mav0/cam1/data.csv";
                   std::vector<std::string> kept;
                   for (const std::string& line : ReadAllLines(list)) {
                     if (kept.size() % 3 != 2 || line.empty()) {
                       kept.push_back(line);
                     } else {
                       kept.push_back("# " + line);
                     }
                   }
                   WriteAllLines(list, kept);
                 },
                 Level::kWarn, "pairs-incomplete"},
        Stranger{"kalibr_word",
                 [](const std::string& f) {
                   ReplaceInFile(f + "/mav0/cam0/sensor.yaml", "radial-tangential", "radtan");
                 },
                 Level::kOk, "camera: raw stereo pair"},
        Stranger{"unknown_lens",
                 [](const std::string& f) {
                   ReplaceInFile(f + "/mav0/cam1/sensor.yaml", "radial-tangential", "fov");
                 },
                 Level::kFail,
                 "distortion_model is 'fov', only radial-tangential, radtan, equidistant"},
        Stranger{"t_bs_no_rotation",
                 [](const std::string& f) {
                   ReplaceInFile(f + "/mav0/cam1/sensor.yaml", "data: [1, ", "data: [2, ");
                 },
                 Level::kFail, "T_BS is no motion"},
        Stranger{"cameras_exchanged",
                 [](const std::string& f) { Exchange(f, "/mav0/cam0", "/mav0/cam1"); },
                 Level::kFail, "mostly along +x"},
        Stranger{"pictures_exchanged",
                 [](const std::string& f) { Exchange(f, "/mav0/cam0/data", "/mav0/cam1/data"); },
                 Level::kFail, "pair-exchanged"}),
    testing::NamedBy(&Stranger::name));

}  // namespace
}  // namespace corbslam::tests

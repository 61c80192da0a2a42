// Tests what corbslam doctor --source says of RGB-D recordings as strangers bring them.
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
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "services/tool/doctor/local_checks.h"
#include "slam/util/testing/case_name.h"
#include "slam/util/text_file.h"
#include "tests/strangers/strange_recordings.h"

namespace corbslam::tests {

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

std::string Recording() { return std::string(CORBSLAM_SOURCE_DIR) + "/tests/data/tum_fr1_xyz"; }

using Change = std::function<void(const std::string&)>;

struct Stranger {
  const char* name;
  Change change;     // Changes a sound recording in this folder.
  Level level;       // Level of the worst finding.
  const char* says;  // Text in one of the findings of that level; empty: not looked at.
  const char* options = "";
};

void PrintTo(const Stranger& stranger, std::ostream* out) { *out << stranger.name; }

std::vector<std::string> Fields(const std::string& line) { return absl::StrSplit(line, ' '); }

// Puts another time into line i, by what it was in seconds.
Change Retime(const std::function<std::string(size_t, const std::string&)>& retime) {
  return [retime](const std::string& folder) {
    std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
    for (size_t i = 0; i < lines.size(); ++i) {
      const std::vector<std::string> f = Fields(lines[i]);
      lines[i] = absl::StrCat(retime(i, f[0]), " ", f[1], " ", retime(i, f[2]), " ", f[3]);
    }
    WriteAllLines(folder + "/associated.txt", lines);
  };
}

std::string Shifted(const std::string& time, int64_t seconds) {
  return FormatSeconds(*ParseSeconds(time) + seconds * 1'000'000'000);
}

Change ScaleGrey(int type, double factor) {
  return [=](const std::string& folder) {
    ChangePictures(folder, "rgb", cv::IMREAD_UNCHANGED, [=](const cv::Mat& image) {
      cv::Mat scaled;
      image.convertTo(scaled, type, factor);
      return scaled;
    });
  };
}

Change ScaleDepth(double factor, double offset = 0) {
  return [=](const std::string& folder) {
    ChangePictures(folder, "depth", cv::IMREAD_UNCHANGED, [=](const cv::Mat& image) {
      cv::Mat scaled;
      image.convertTo(scaled, CV_16UC1, factor, offset);
      return scaled;
    });
  };
}

void HalveBoth(const std::string& folder) {
  for (const char* kind : {"rgb", "depth"}) {
    ChangePictures(folder, kind, cv::IMREAD_UNCHANGED, [](const cv::Mat& image) {
      cv::Mat half;
      cv::resize(image, half, {}, 0.5, 0.5, cv::INTER_NEAREST);
      return half;
    });
  }
}

Change Calibration(const std::vector<std::string>& lines) {
  return [lines](const std::string& folder) { WriteAllLines(folder + "/calibration.yaml", lines); };
}

// Makes the depth image the one of `behind` frames later.
void MakeDepthLate(const std::string& folder, size_t behind) {
  std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
  std::vector<std::string> late;
  for (size_t i = 0; i + behind < lines.size(); ++i) {
    const std::vector<std::string> f = Fields(lines[i]);
    late.push_back(absl::StrCat(f[0], " ", f[1], " ", f[2], " ", Fields(lines[i + behind])[3]));
  }
  WriteAllLines(folder + "/associated.txt", late);
}

void DropPicture(const std::string& folder, size_t line, const std::string& bytes) {
  const std::string path =
      absl::StrCat(folder, "/", Fields(ReadAllLines(folder + "/associated.txt")[line])[1]);
  fs::remove(path);
  if (!bytes.empty()) WriteAllLines(path, {bytes});
}

class StrangerRgbdTest : public ::testing::TestWithParam<Stranger> {};

TEST_P(StrangerRgbdTest, IsTakenRightlyOrNamed) {
  const Stranger& stranger = GetParam();
  const std::string folder = CopyRgbd(Recording(), stranger.name);
  stranger.change(folder);
  const Findings findings = CheckSource(absl::StrCat("tum:", folder, stranger.options), false);
  Level worst = Level::kOk;
  std::vector<std::string> texts;
  for (const Finding& finding : findings) worst = std::max(worst, finding.level);
  for (const Finding& finding : findings) {
    if (finding.level == worst) texts.push_back(absl::StrCat(finding.text, "|", finding.advice));
  }
  EXPECT_EQ(ToString(worst), ToString(stranger.level)) << FormatFindings(findings);
  EXPECT_THAT(texts, Contains(HasSubstr(stranger.says)));
}

INSTANTIATE_TEST_SUITE_P(
    Sound, StrangerRgbdTest,
    ::testing::Values(
        Stranger{"as_it_is", [](const std::string&) {}, Level::kOk, "times: "},
        Stranger{"columns_turned",
                 [](const std::string& folder) {
                   std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
                   for (std::string& line : lines) {
                     const std::vector<std::string> f = Fields(line);
                     line = absl::StrCat(f[2], "\t", f[3], "\t", f[0], "\t", f[1], "\r");
                   }
                   fs::remove(folder + "/associated.txt");
                   WriteAllLines(folder + "/associations.txt", lines);
                 },
                 Level::kOk, "associations.txt"},
        Stranger{"eth3d",
                 [](const std::string& folder) {
                   fs::remove(folder + "/calibration.yaml");
                   WriteAllLines(folder + "/calibration.txt", {"517.3 516.5 318.6 255.3"});
                 },
                 Level::kOk, "from "},
        Stranger{"camera_option",
                 [](const std::string& folder) { fs::remove(folder + "/calibration.yaml"); },
                 Level::kOk, "from ?camera=freiburg1", "?camera=freiburg1"},
        Stranger{"byte_order_mark",
                 [](const std::string& folder) {
                   for (const char* name : {"/associated.txt", "/calibration.yaml"}) {
                     std::vector<std::string> lines = ReadAllLines(folder + name);
                     lines[0] = "\xef\xbb\xbf" + lines[0];
                     WriteAllLines(folder + name, lines);
                   }
                 },
                 Level::kOk, ""},
        Stranger{"grey_x257", ScaleGrey(CV_16UC1, 257), Level::kOk, ""},
        Stranger{"jpeg",
                 [](const std::string& folder) {
                   ReplaceInFile(folder + "/associated.txt", ".png 1", ".jpg 1");
                   for (const std::string& path : FilesOf(folder + "/rgb")) {
                     cv::imwrite(absl::StrReplaceAll(path, {{".png", ".jpg"}}),
                                 cv::imread(path, cv::IMREAD_UNCHANGED));
                   }
                 },
                 Level::kOk, ""}),
    testing::NamedBy(&Stranger::name));

INSTANTIATE_TEST_SUITE_P(
    Calibrations, StrangerRgbdTest,
    ::testing::Values(
        Stranger{"no_calibration",
                 [](const std::string& folder) {
                   fs::remove(folder + "/calibration.yaml");
                   // The pictures are no links, so that nothing leads to the recording that knows
                   // its camera.
                   for (const char* kind : {"rgb", "depth"}) {
                     ChangeBytes(folder, kind, [](const std::string& bytes) { return bytes; });
                   }
                 },
                 Level::kFail, "no calibration. Put calibration.yaml there"},
        Stranger{"half_size", HalveBoth, Level::kFail, "cx 318.643 px of 320 can't be"},
        Stranger{"half_size_named",
                 [](const std::string& folder) {
                   HalveBoth(folder);
                   fs::remove(folder + "/calibration.yaml");
                 },
                 Level::kFail, "these intrinsics are of 640x480 pictures", "?camera=freiburg1"},
        Stranger{"eth3d_of_another_camera",
                 [](const std::string& folder) {
                   fs::remove(folder + "/calibration.yaml");
                   WriteAllLines(folder + "/calibration.txt", {"100 100 50 50"});
                 },
                 Level::kFail, "calibration.txt: cx 50 px of 640 can't be"},
        Stranger{"fields_missing", Calibration({"fx: 517", "fy: 516", "cx: 318"}), Level::kFail,
                 "calibration.yaml: cy is missing"},
        Stranger{"field_twice", Calibration({"fx: 517", "fy: 516", "cx: 318", "cy: 255", "fx: 1"}),
                 Level::kFail, "fx is there twice"},
        Stranger{"fields_exchanged",
                 Calibration({"fx: 318.6", "fy: 255.3", "cx: 517.3", "cy: 516"}), Level::kFail,
                 "can't be"},
        Stranger{"field_nan", Calibration({"fx: .nan", "fy: 516", "cx: 318", "cy: 255"}),
                 Level::kFail, "calibration.yaml:1: fx is no finite number"},
        Stranger{"unknown_distortion",
                 Calibration({"fx: 517", "fy: 516", "cx: 318", "cy: 255", "k4: 0.1"}), Level::kFail,
                 "unknown field k4"},
        Stranger{"no_yaml", Calibration({"fx = 517", "fy = 516"}), Level::kFail,
                 "calibration.yaml"},
        Stranger{
            "principal_point_off",
            Calibration({"fx: 517", "fy: 516", "cx: 420", "cy: 255", "depth_units_per_m: 5000"}),
            Level::kWarn, "calibration-improbable"}),
    testing::NamedBy(&Stranger::name));

INSTANTIATE_TEST_SUITE_P(
    Times, StrangerRgbdTest,
    ::testing::Values(
        Stranger{"all_of_one_time",
                 Retime([](size_t, const std::string&) { return "1305031102.175304"; }),
                 Level::kFail,
                 "associated.txt:2: the time 1305031102.175304000 s stands in line 1"},
        Stranger{"time_jumps_back", Retime([](size_t i, const std::string& time) {
                   return Shifted(time, i > 15 ? -10 : 0);
                 }),
                 Level::kWarn, "times-jump-back"},
        Stranger{"listed_twice",
                 [](const std::string& folder) {
                   std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
                   const std::vector<std::string> again = lines;
                   lines.insert(lines.end(), again.begin(), again.end());
                   WriteAllLines(folder + "/associated.txt", lines);
                 },
                 Level::kWarn, "associated.txt:31: the time jumps back"},
        Stranger{"two_exchanged",
                 [](const std::string& folder) {
                   std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
                   std::swap(lines[7], lines[8]);
                   WriteAllLines(folder + "/associated.txt", lines);
                 },
                 Level::kWarn, "times-out-of-order"},
        Stranger{"reversed",
                 [](const std::string& folder) {
                   std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
                   std::reverse(lines.begin(), lines.end());
                   WriteAllLines(folder + "/associated.txt", lines);
                 },
                 Level::kFail, "put the list in the order of time"},
        Stranger{"milliseconds", Retime([](size_t, const std::string& time) {
                   return absl::StrReplaceAll(time.substr(4, 10), {{".", ""}});
                 }),
                 Level::kFail, "s, its depth image of 31102160"},
        Stranger{"negative", Retime([](size_t i, const std::string& time) {
                   return i == 3 ? "-" + time : time;
                 }),
                 Level::kFail, "associated.txt:4: field 1: the time -1305031102"},
        Stranger{"not_a_number",
                 Retime([](size_t i, const std::string& time) { return i == 3 ? "nan" : time; }),
                 Level::kFail, "associated.txt:4: field 1: no time in seconds"},
        Stranger{"gap", Retime([](size_t i, const std::string& time) {
                   return Shifted(time, i > 15 ? 60 : 0);
                 }),
                 Level::kWarn, "times-gap"},
        Stranger{"depth_far_apart",
                 [](const std::string& folder) {
                   std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
                   for (std::string& line : lines) {
                     const std::vector<std::string> f = Fields(line);
                     line = absl::StrCat(f[0], " ", f[1], " ", Shifted(f[2], 3), " ", f[3]);
                   }
                   WriteAllLines(folder + "/associated.txt", lines);
                 },
                 Level::kFail, "associated.txt:1: the picture is of"}),
    testing::NamedBy(&Stranger::name));

INSTANTIATE_TEST_SUITE_P(
    Pictures, StrangerRgbdTest,
    ::testing::Values(
        Stranger{"one_empty", [](const std::string& folder) { DropPicture(folder, 12, " "); },
                 Level::kWarn, "pictures-unreadable"},
        Stranger{"one_missing", [](const std::string& folder) { DropPicture(folder, 12, ""); },
                 Level::kWarn, "pictures-missing"},
        Stranger{"all_cut",
                 [](const std::string& folder) {
                   ChangeBytes(folder, "rgb", [](const std::string& bytes) {
                     return bytes.substr(0, bytes.size() / 2);
                   });
                 },
                 Level::kFail, "the picture is cut short after"},
        Stranger{"grey_10_bits", ScaleGrey(CV_16UC1, 4), Level::kWarn, "grey-bits-assumed"},
        Stranger{"grey_12_bits", ScaleGrey(CV_16UC1, 16), Level::kWarn, "grey-bits-assumed"},
        Stranger{"black", ScaleGrey(CV_8UC1, 0.01), Level::kWarn, "pictures-nearly-black"},
        Stranger{"white", ScaleGrey(CV_8UC1, 50), Level::kWarn, "pictures-overexposed"},
        Stranger{"same_picture",
                 [](const std::string& folder) {
                   const std::vector<std::string> files = FilesOf(folder + "/rgb");
                   const cv::Mat first = cv::imread(files.front(), cv::IMREAD_UNCHANGED);
                   ChangePictures(folder, "rgb", cv::IMREAD_UNCHANGED,
                                  [&](const cv::Mat&) { return first; });
                 },
                 Level::kWarn, "camera-stuck"}),
    testing::NamedBy(&Stranger::name));

INSTANTIATE_TEST_SUITE_P(
    Depths, StrangerRgbdTest,
    ::testing::Values(
        Stranger{"depth_zero", ScaleDepth(0), Level::kFail, "depth-empty"},
        Stranger{"depth_65535", ScaleDepth(0, 65535), Level::kFail, ""},
        Stranger{"depth_constant", ScaleDepth(0, 7000), Level::kFail, "depth-constant"},
        Stranger{"depth_in_mm",
                 [](const std::string& folder) {
                   ReplaceInFile(folder + "/calibration.yaml", "depth_units_per_m: 5000",
                                 "depth_units_per_m: 100");
                 },
                 Level::kWarn, "depth-units-implausible"},
        Stranger{"depth_8_bits",
                 [](const std::string& folder) {
                   ChangePictures(folder, "depth", cv::IMREAD_UNCHANGED, [](const cv::Mat& depth) {
                     cv::Mat grey;
                     depth.convertTo(grey, CV_8UC1, 1.0 / 256);
                     return grey;
                   });
                 },
                 Level::kFail, "one channel of 16 bits"},
        Stranger{"depth_late", [](const std::string& folder) { MakeDepthLate(folder, 3); },
                 Level::kWarn, "depth-late"},
        Stranger{"depth_of_half_size",
                 [](const std::string& folder) {
                   ChangePictures(folder, "depth", cv::IMREAD_UNCHANGED, [](const cv::Mat& depth) {
                     return cv::Mat(depth, cv::Rect(0, 0, 320, 240)).clone();
                   });
                 },
                 Level::kFail, "320x240 pixels, the calibration is of 640x480"}),
    testing::NamedBy(&Stranger::name));

}  // namespace
}  // namespace corbslam::tests

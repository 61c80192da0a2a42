#include "tests/strangers/strange_recordings.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/sequence/sequence_writer.h"

namespace corbslam::tests {

using client_agent::ParseSourceSpec;
using client_agent::SourceLayout;
using services::RegisterSimulatedSources;
using services::WriteSequence;
using services::WriteSequenceOptions;

namespace {

namespace fs = std::filesystem;

// The town has rows and columns enough for the checks, and few enough to be drawn in seconds.
constexpr char kDrawn[] = "sim:city?seed=7&length=40&picture_scale=0.4&rig=kitti";

std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

void ReplaceFile(const std::string& path, const std::string& bytes) {
  fs::remove(path);
  std::ofstream(path, std::ios::binary) << bytes;
}

bool IsPicture(const fs::path& path) { return path.extension() == ".png"; }

// Makes links for pictures, and copies of everything else.
void CopyFolder(const fs::path& from, const fs::path& to) {
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(from)) {
    const fs::path there = to / fs::relative(entry.path(), from);
    if (entry.is_directory()) {
      fs::create_directories(there);
    } else if (IsPicture(entry.path())) {
      fs::create_symlink(fs::absolute(entry.path()), there);
    } else {
      fs::copy_file(entry.path(), there);
    }
  }
}

// Each process has a folder of its own, because tests run at the same time.
std::string DrawnFolder(SourceLayout layout) {
  return absl::StrCat(::testing::TempDir(), "/strangers_drawn_", getpid(), "_",
                      static_cast<int>(layout));
}

}  // namespace

std::string MakeStrangerFolder(const std::string& name) {
  const std::string folder = absl::StrCat(::testing::TempDir(), "/strangers_", getpid(), "/", name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::vector<std::string> ReadAllLines(const std::string& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

void WriteAllLines(const std::string& path, const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) absl::StrAppend(&text, line, "\n");
  ReplaceFile(path, text);
}

void ReplaceInFile(const std::string& path, const std::string& from, const std::string& to) {
  const std::string before = ReadBytes(path);
  const std::string after = absl::StrReplaceAll(before, {{from, to}});
  EXPECT_NE(before, after) << path << " has no " << from;
  ReplaceFile(path, after);
}

std::string CopyRgbd(const std::string& recording, const std::string& name, size_t frames) {
  const std::string folder = MakeStrangerFolder(name);
  std::vector<std::string> lines = ReadAllLines(recording + "/associated.txt");
  lines.resize(std::min(frames, lines.size()));
  WriteAllLines(folder + "/associated.txt", lines);
  WriteAllLines(folder + "/calibration.yaml",
                {"fx: 517.306408", "fy: 516.469215", "cx: 318.643040", "cy: 255.313989",
                 "k1: 0.262383", "k2: -0.953104", "p1: -0.005358", "p2: 0.002628", "k3: 1.163314",
                 "depth_units_per_m: 5000"});
  for (const char* kind : {"rgb", "depth"}) {
    fs::create_directories(absl::StrCat(folder, "/", kind));
    const std::vector<std::string> files = FilesOf(absl::StrCat(recording, "/", kind));
    for (const std::string& file : files) {
      fs::create_symlink(file,
                         absl::StrCat(folder, "/", kind, "/", fs::path(file).filename().string()));
    }
  }
  return folder;
}

std::string CopyStereo(SourceLayout layout, const std::string& name) {
  const std::string drawn = DrawnFolder(layout);
  if (!fs::exists(drawn)) {
    WriteSequenceOptions options;
    options.layout = layout;
    options.folder = drawn;
    RegisterSimulatedSources();
    const auto written = WriteSequence(*ParseSourceSpec(kDrawn), options);
    EXPECT_TRUE(written.ok()) << written.status();
  }
  const std::string folder = MakeStrangerFolder(name);
  CopyFolder(drawn, folder);
  return folder;
}

void ChangePictures(const std::string& directory, const std::string& folder, int flags,
                    const std::function<cv::Mat(const cv::Mat&)>& change) {
  for (const std::string& path : FilesOf(absl::StrCat(directory, "/", folder))) {
    const cv::Mat changed = change(cv::imread(path, flags));
    fs::remove(path);
    EXPECT_TRUE(cv::imwrite(path, changed)) << path;
  }
}

void ChangeBytes(const std::string& directory, const std::string& folder,
                 const std::function<std::string(const std::string&)>& change) {
  for (const std::string& path : FilesOf(absl::StrCat(directory, "/", folder))) {
    ReplaceFile(path, change(ReadBytes(path)));
  }
}

std::vector<std::string> FilesOf(const std::string& folder) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace corbslam::tests

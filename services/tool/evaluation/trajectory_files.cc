#include "services/tool/evaluation/trajectory_files.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "absl/algorithm/container.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "slam/evaluation/pose_header.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

namespace {

std::string NameOf(const std::string& local_map, const LocalMapNames& names) {
  const auto name = names.find(local_map);
  return absl::StrCat("local map ", name == names.end() ? "" : name->second + ", ", local_map);
}

// Returns the least of the numbers that people know the file's local maps by; nullopt if none has
// one.
std::optional<size_t> LeastNumber(const TrajectoryFile& file, const LocalMapNames& names) {
  std::optional<size_t> least;
  for (const TrajectoryPart& part : file) {
    const auto name = names.find(part.local_map);
    size_t number = 0;
    if (name == names.end()) continue;
    if (!absl::SimpleAtoi(name->second.substr(name->second.rfind('/') + 1), &number)) continue;
    least = std::min(least.value_or(number), number);
  }
  return least;
}

// Returns path's file with a suffix before its ending.
std::string WithSuffix(const std::string& path, const std::string& suffix) {
  const std::filesystem::path whole(path);
  const std::string name = absl::StrCat(whole.stem().string(), suffix, whole.extension().string());
  return std::filesystem::path(whole).replace_filename(name).string();
}

// Writes a comment before each part, the first one behind the header: two comments never follow
// each other, so that a plain comparison of a line's first word with the one before finds times
// only.
std::vector<std::string> TumLines(const TrajectoryFile& file, const std::string& header,
                                  const LocalMapNames& names) {
  std::vector<std::string> lines;
  if (file.empty()) lines.push_back(header);
  for (const TrajectoryPart& part : file) {
    lines.push_back(absl::StrCat(lines.empty() ? absl::StrCat(header, "; ") : "# ",
                                 NameOf(part.local_map, names)));
    for (const StampedPose& pose : part.poses) lines.push_back(TumRow(pose));
  }
  return lines;
}

}  // namespace

std::vector<TrajectoryPart> PartsOf(const ServedTrajectory& served) {
  std::vector<TrajectoryPart> parts;
  std::map<std::pair<std::string, std::string>, size_t> numbers;
  for (const ServedPose& pose : served) {
    const auto [it, added] = numbers.try_emplace({pose.local_map, pose.island}, parts.size());
    if (added) parts.push_back({pose.local_map, {}, pose.island});
    parts[it->second].poses.push_back({pose.timestamp_ns, pose.frame_from_camera});
  }
  // Merging leaves no time twice.
  for (TrajectoryPart& part : parts) part.poses = MergeByTime({part.poses});
  std::stable_sort(parts.begin(), parts.end(),
                   [](const TrajectoryPart& a, const TrajectoryPart& b) {
                     return a.poses.front().timestamp_ns < b.poses.front().timestamp_ns;
                   });
  return parts;
}

std::vector<TrajectoryFile> ShareFiles(std::vector<TrajectoryPart> parts) {
  std::vector<TrajectoryFile> files(1);
  for (TrajectoryPart& part : parts) {
    const int64_t begin_ns = part.poses.front().timestamp_ns;
    const auto file = std::find_if(files.begin(), files.end(), [&](const TrajectoryFile& before) {
      return before.empty() || before.back().poses.back().timestamp_ns < begin_ns;
    });
    if (file != files.end()) {
      file->push_back(std::move(part));
    } else {
      files.push_back({std::move(part)});
    }
  }
  return files;
}

std::vector<TrajectoryFile> OwnFiles(std::vector<TrajectoryPart> parts) {
  std::vector<TrajectoryFile> files;
  for (TrajectoryPart& part : parts) files.push_back({std::move(part)});
  if (files.empty()) files.emplace_back();
  return files;
}

Trajectory Join(const TrajectoryFile& file) {
  Trajectory all;
  for (const TrajectoryPart& part : file) {
    all.insert(all.end(), part.poses.begin(), part.poses.end());
  }
  return all;
}

std::vector<std::string> SuffixesOf(const std::vector<TrajectoryFile>& files,
                                    const LocalMapNames& names) {
  std::vector<std::string> suffixes;
  for (size_t i = 0; i < files.size(); ++i) {
    const std::string number = absl::StrCat("+", LeastNumber(files[i], names).value_or(i + 1));
    std::string suffix = i == 0 ? "" : number;
    for (char letter = 'b'; absl::c_linear_search(suffixes, suffix); ++letter) {
      suffix = absl::StrCat(number, std::string(1, letter));
    }
    suffixes.push_back(std::move(suffix));
  }
  return suffixes;
}

std::vector<std::string> SuffixedPaths(const std::string& path,
                                       const std::vector<std::string>& suffixes) {
  std::vector<std::string> paths;
  for (const std::string& suffix : suffixes) {
    paths.push_back(suffix.empty() ? path : WithSuffix(path, suffix));
  }
  return paths;
}

std::vector<std::string> DescribeParts(const TrajectoryFile& file, const LocalMapNames& names) {
  std::vector<std::string> lines;
  size_t before = 0;
  for (const TrajectoryPart& part : file) {
    lines.push_back(absl::StrCat(NameOf(part.local_map, names), ": poses ", before + 1, " to ",
                                 before + part.poses.size()));
    before += part.poses.size();
  }
  return lines;
}

absl::Status WriteTumFiles(const std::vector<TrajectoryFile>& files, PosesOf poses_of,
                           const std::string& frame, const std::vector<std::string>& paths,
                           const LocalMapNames& names) {
  for (size_t i = 0; i < files.size(); ++i) {
    const std::string header = absl::StrCat("# ", PoseHeaderLine(poses_of), " ", frame,
                                            ": timestamp tx ty tz qx qy qz qw");
    RETURN_IF_ERROR(WriteLines(TumLines(files[i], header, names), paths[i]));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::services

#include "services/tool/evaluation/trajectory_files.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/evaluation/pose_header.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

namespace {

// Writes a comment before each part, the first one behind the header: two comments never follow
// each other, so that a plain comparison of a line's first word with the one before finds times
// only.
std::vector<std::string> TumLines(const TrajectoryFile& file, const std::string& header) {
  std::vector<std::string> lines;
  if (file.empty()) lines.push_back(header);
  for (const TrajectoryPart& part : file) {
    lines.push_back(absl::StrCat(lines.empty() ? absl::StrCat(header, "; ") : "# ", "local map ",
                                 part.local_map));
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

std::string NumberedPath(const std::string& path, size_t number) {
  if (number == 1) return path;
  const std::filesystem::path whole(path);
  const std::string name =
      absl::StrCat(whole.stem().string(), "+", number, whole.extension().string());
  return std::filesystem::path(whole).replace_filename(name).string();
}

std::vector<std::string> DescribeParts(const TrajectoryFile& file) {
  std::vector<std::string> lines;
  size_t before = 0;
  for (const TrajectoryPart& part : file) {
    lines.push_back(absl::StrCat("local map ", part.local_map, ": poses ", before + 1, " to ",
                                 before + part.poses.size()));
    before += part.poses.size();
  }
  return lines;
}

absl::Status WriteTumFiles(const std::vector<TrajectoryFile>& files, PosesOf poses_of,
                           const std::string& frame, const std::string& path) {
  for (size_t i = 0; i < files.size(); ++i) {
    const std::string header = absl::StrCat("# ", PoseHeaderLine(poses_of), " ", frame,
                                            ": timestamp tx ty tz qx qy qz qw");
    RETURN_IF_ERROR(WriteLines(TumLines(files[i], header), NumberedPath(path, i + 1)));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::services

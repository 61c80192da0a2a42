#include "services/tool/commands/export_trajectories.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/client/store/local_map_names.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/tool/evaluation/trajectory_files.h"
#include "services/tool/export/euroc_file.h"
#include "services/tool/mission/mission_summary.h"
#include "services/tool/output/result.h"
#include "slam/evaluation/pose_header.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/atomic_file.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {
namespace {

constexpr char kReadmeBegins[] = "Trajectories of mission ";
constexpr char kGlobalFrame[] = "in the mission's global frame, that of its first local map";

absl::Status WriteTimes(const Trajectory& trajectory, const std::string& path) {
  std::vector<std::string> lines;
  for (const StampedPose& pose : trajectory) lines.push_back(FormatSeconds(pose.timestamp_ns));
  return WriteLines(lines, path);
}

// Writes a file without comments: readers of these forms would stumble over them, so they stand in
// the README only.
absl::Status WriteBare(const Trajectory& trajectory, const std::string& format,
                       const std::string& path) {
  if (format == "euroc") return WriteEurocTrajectory(trajectory, path);
  RETURN_IF_ERROR(WriteKittiTrajectory(trajectory, path));
  return WriteTimes(trajectory, path + ".times");
}

absl::Status WriteFiles(const std::vector<TrajectoryFile>& files, const std::string& format,
                        PosesOf poses_of, const std::vector<std::string>& paths,
                        const LocalMapNames& names) {
  // A device or a pipe has room for one file.
  if (files.size() > 1 || format == "kitti") {
    RETURN_IF_ERROR(CheckForPlainFile(
        paths[0], files.size() > 1
                      ? absl::StrCat("the robot's drives make ", files.size(), " files")
                      : "the times go into a second file, beside it"));
  }
  if (format == "tum") return WriteTumFiles(files, poses_of, kGlobalFrame, paths, names);
  for (size_t i = 0; i < files.size(); ++i) {
    RETURN_IF_ERROR(WriteBare(Join(files[i]), format, paths[i]));
  }
  return absl::OkStatus();
}

// Removes the files of which the README of an earlier export into the folder speaks: those of two
// exports side by side would be taken for one.
absl::Status RemoveEarlierExport(const std::string& folder) {
  std::error_code error;
  const std::string readme = folder + "/README.md";
  if (!std::filesystem::is_regular_file(readme, error)) return absl::OkStatus();
  bool is_ours = false;
  return ForEachLine(readme, [&](int line, absl::string_view text) -> absl::Status {
    if (line == 1) is_ours = absl::StartsWith(text, kReadmeBegins);
    const size_t end = text.find(": robot ");
    const std::string name(text.substr(0, end));
    if (!is_ours || end == absl::string_view::npos || absl::StrContains(name, "/")) {
      return absl::OkStatus();
    }
    for (const char* ending : {"", ".times"}) {
      const std::filesystem::path file = absl::StrCat(folder, "/", name, ending);
      const bool is_plain =
          std::filesystem::is_regular_file(std::filesystem::symlink_status(file, error));
      if (is_plain) std::filesystem::remove(file, error);
    }
    return absl::OkStatus();
  });
}

class TrajectoryExport {
 public:
  TrajectoryExport(const MissionArguments& arguments, PosesOf poses_of, LocalMapNames names,
                   StoreReader& store)
      : arguments_(arguments), poses_of_(poses_of), names_(std::move(names)), store_(store) {
    readme_ = {absl::StrCat(kReadmeBegins, arguments.mission, " as ", arguments.format, ": ",
                            PoseHeaderLine(poses_of), ","),
               absl::StrCat(kGlobalFrame, "; times are of each robot's own clock.")};
  }

  // Passes over a robot of which nothing is connected to the global frame.
  absl::Status Add(const std::string& agent, const std::string& path) {
    UnposedFrames unposed;
    ASSIGN_OR_RETURN(const ServedTrajectory served,
                     store_.ReadTrajectory(agent, v1::TRAJECTORY_FRAME_GLOBAL, poses_of_,
                                           StoreReader::Reach::kGlobalFrame, &unposed));
    const std::string nothing = absl::StrCat(
        agent, ": nothing of it is connected to the global frame (", Describe(unposed), ")");
    if (served.empty() && !arguments_.agent.empty()) {
      return absl::NotFoundError("robot " + nothing);
    }
    if (served.empty()) {
      Say(nothing + "\n");
      rows_.push_back({{"agent", agent}, {"file", nullptr}, {"poses", 0}});
      return absl::OkStatus();
    }
    const std::vector<TrajectoryFile> files = ShareFiles(PartsOf(served));
    const std::vector<std::string> paths = SuffixedPaths(path, SuffixesOf(files, names_));
    RETURN_IF_ERROR(WriteFiles(files, arguments_.format, poses_of_, paths, names_));
    for (size_t i = 0; i < files.size(); ++i) Note(agent, files[i], paths[i]);
    return absl::OkStatus();
  }

  // Prints which files there are.
  void Print() const { PrintResult("", rows_); }
  const std::vector<std::string>& readme() const { return readme_; }

 private:
  void Note(const std::string& agent, const TrajectoryFile& file, const std::string& path) {
    const size_t poses = Join(file).size();
    Say(absl::StrCat(path, ": ", poses, " poses of ", agent, "\n"));
    rows_.push_back({{"agent", agent}, {"file", path}, {"poses", poses}});
    const std::string name = std::filesystem::path(path).filename().string();
    for (const std::string& part : DescribeParts(file, names_)) {
      readme_.push_back(absl::StrCat(name, ": robot ", agent, ", ", part));
    }
  }

  const MissionArguments& arguments_;
  const PosesOf poses_of_;
  const LocalMapNames names_;
  StoreReader& store_;
  std::vector<std::string> readme_;
  nlohmann::ordered_json rows_ = nlohmann::ordered_json::array();
};

}  // namespace

absl::Status ExportTrajectories(const MissionArguments& arguments,
                                const std::shared_ptr<grpc::Channel>& channel) {
  StoreReader store(channel, arguments.mission);
  ASSIGN_OR_RETURN(const PosesOf poses_of,
                   ParsePosesOf(arguments.poses_of.empty() ? "camera" : arguments.poses_of));
  ASSIGN_OR_RETURN(const MissionSummary summary, ReadSummary(channel, arguments.mission));
  TrajectoryExport exporting(arguments, poses_of, ShortNames(summary.local_maps), store);
  if (!arguments.agent.empty()) {
    RETURN_IF_ERROR(CheckNameSegment("--agent", arguments.agent));
    RETURN_IF_ERROR(exporting.Add(arguments.agent, arguments.file));
    RETURN_IF_ERROR(WriteReadme(exporting.readme(), arguments.file));
    exporting.Print();
    return absl::OkStatus();
  }
  RETURN_IF_ERROR(MakeFolder(arguments.file));
  RETURN_IF_ERROR(RemoveEarlierExport(arguments.file));
  const std::string ending = arguments.format == "euroc" ? ".csv" : ".txt";
  for (const v1::MissionAgent& agent : summary.agents) {
    const std::string name = LastSegment(agent.name());
    RETURN_IF_ERROR(exporting.Add(name, absl::StrCat(arguments.file, "/", name, ending)));
  }
  RETURN_IF_ERROR(WriteLines(exporting.readme(), arguments.file + "/README.md"));
  exporting.Print();
  return absl::OkStatus();
}

}  // namespace corbslam::services

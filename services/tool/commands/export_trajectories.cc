#include "services/tool/commands/export_trajectories.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/tool/evaluation/trajectory_files.h"
#include "services/tool/export/euroc_file.h"
#include "services/tool/mission/mission_summary.h"
#include "services/tool/output/result.h"
#include "slam/evaluation/pose_header.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {
namespace {

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
                        PosesOf poses_of, const std::string& path) {
  if (format == "tum") return WriteTumFiles(files, poses_of, kGlobalFrame, path);
  for (size_t i = 0; i < files.size(); ++i) {
    RETURN_IF_ERROR(WriteBare(Join(files[i]), format, NumberedPath(path, i + 1)));
  }
  return absl::OkStatus();
}

class TrajectoryExport {
 public:
  TrajectoryExport(const MissionArguments& arguments, PosesOf poses_of, StoreReader& store)
      : arguments_(arguments), poses_of_(poses_of), store_(store) {
    readme_ = {absl::StrCat("Trajectories of mission ", arguments.mission, " as ", arguments.format,
                            ": ", PoseHeaderLine(poses_of), ","),
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
    RETURN_IF_ERROR(WriteFiles(files, arguments_.format, poses_of_, path));
    for (size_t i = 0; i < files.size(); ++i) Note(agent, files[i], NumberedPath(path, i + 1));
    return absl::OkStatus();
  }

  // Writes the README, and prints which files there are.
  absl::Status Finish(const std::string& readme) const {
    RETURN_IF_ERROR(WriteLines(readme_, readme));
    PrintResult("", rows_);
    return absl::OkStatus();
  }

 private:
  void Note(const std::string& agent, const TrajectoryFile& file, const std::string& path) {
    const size_t poses = Join(file).size();
    Say(absl::StrCat(path, ": ", poses, " poses of ", agent, "\n"));
    rows_.push_back({{"agent", agent}, {"file", path}, {"poses", poses}});
    const std::string name = std::filesystem::path(path).filename().string();
    for (const std::string& part : DescribeParts(file)) {
      readme_.push_back(absl::StrCat(name, ": robot ", agent, ", ", part));
    }
  }

  const MissionArguments& arguments_;
  const PosesOf poses_of_;
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
  TrajectoryExport exporting(arguments, poses_of, store);
  if (!arguments.agent.empty()) {
    RETURN_IF_ERROR(CheckNameSegment("--agent", arguments.agent));
    RETURN_IF_ERROR(exporting.Add(arguments.agent, arguments.file));
    return exporting.Finish(arguments.file + ".README.md");
  }
  ASSIGN_OR_RETURN(const auto agents, ReadAgents(channel, arguments.mission));
  RETURN_IF_ERROR(MakeFolder(arguments.file));
  const std::string ending = arguments.format == "euroc" ? ".csv" : ".txt";
  for (const v1::MissionAgent& agent : agents) {
    const std::string name = LastSegment(agent.name());
    RETURN_IF_ERROR(exporting.Add(name, absl::StrCat(arguments.file, "/", name, ending)));
  }
  return exporting.Finish(arguments.file + "/README.md");
}

}  // namespace corbslam::services

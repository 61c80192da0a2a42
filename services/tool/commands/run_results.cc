#include "services/tool/commands/run_results.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/tool/evaluation/picture.h"
#include "services/tool/evaluation/report_detail.h"
#include "services/tool/evaluation/trajectory_files.h"
#include "services/viewer/page_path.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {
namespace {

// Writes the files of one robot at `path` and beside it.
absl::Status WriteRobotFiles(const std::vector<TrajectoryFile>& files, const std::string& frame,
                             const LocalMapNames& names, const std::string& path) {
  return WriteTumFiles(files, PosesOf::kRecordedCamera, frame,
                       SuffixedPaths(path, SuffixesOf(files, names)), names);
}

absl::Status WriteTrajectories(const MissionOutcome& outcome, const std::string& folder) {
  const LocalMapNames& names = outcome.local_map_names;
  for (const RobotPaths& paths : outcome.paths) {
    const std::string stem = absl::StrCat(folder, "/", paths.name);
    RETURN_IF_ERROR(WriteRobotFiles(OwnFiles(PartsOf(paths.local)), "in the frame of the local map",
                                    names, stem + ".local.tum"));
    RETURN_IF_ERROR(WriteRobotFiles(ShareFiles(PartsOf(paths.global)),
                                    "in the mission's global frame", names, stem + ".global.tum"));
    RETURN_IF_ERROR(WriteToldPaths(paths.told, stem + ".told"));
  }
  return absl::OkStatus();
}

absl::Status WritePicture(const MissionOutcome& outcome, const Accuracy& accuracy,
                          const std::string& own, const std::string& path) {
  ASSIGN_OR_RETURN(const cv::Mat image, RenderMap(ComposePicture(outcome.map, own, accuracy.fused,
                                                                 DrivenOf(outcome.paths))));
  return WriteImage(image, path);
}

// Writes what each robot holds as NAME.map.png, and nearer as NAME.near.png.
absl::Status WriteHeldPictures(const std::vector<ReportDetail::Held>& held,
                               const std::string& folder) {
  for (const ReportDetail::Held& robot : held) {
    const std::string stem = absl::StrCat(folder, "/", robot.robot);
    ASSIGN_OR_RETURN(const cv::Mat whole, RenderMap(robot.map));
    RETURN_IF_ERROR(WriteImage(whole, stem + ".map.png"));
    if (!robot.nearer.has_value()) continue;
    ASSIGN_OR_RETURN(const cv::Mat nearer, RenderMap(*robot.nearer));
    RETURN_IF_ERROR(WriteImage(nearer, stem + ".near.png"));
  }
  return absl::OkStatus();
}

std::optional<double> RmseOf(const std::optional<AbsoluteError>& error) {
  return error.has_value() ? std::optional(error->rmse_m) : std::nullopt;
}

void AddAccuracy(const Accuracy& accuracy, RunReport& report) {
  for (size_t i = 0; i < std::min(accuracy.robots.size(), report.robots.size()); ++i) {
    report.robots[i].ate_m = accuracy.robots[i].ate_m;
    report.robots[i].ate_from_frame_m = accuracy.robots[i].ate_from_frame_m;
    report.robots[i].ate_global_m = accuracy.robots[i].ate_global_m;
    report.robots[i].told_ate_m = accuracy.robots[i].told.ate_m;
    report.robots[i].told_ate_before_m = accuracy.robots[i].told.ate_before_m;
    if (accuracy.robots[i].relative.has_value()) {
      report.robots[i].t_rel_percent = accuracy.robots[i].relative->translation_percent;
      report.robots[i].r_rel_deg_per_100m = accuracy.robots[i].relative->rotation_deg_per_100m;
    }
  }
  report.fused.ate_m = RmseOf(accuracy.fused.all);
  report.fused.ate_from_frame_m = RmseOf(accuracy.fused.from_frame);
  report.fused.ate_without_scale_m = RmseOf(accuracy.fused.without_scale);
  if (accuracy.fused.without_scale.has_value()) {
    report.fused.scale = accuracy.fused.without_scale->truth_from_estimate.scale;
  }
  if (accuracy.fused.relative.has_value()) {
    report.fused.t_rel_percent = accuracy.fused.relative->translation_percent;
    report.fused.r_rel_deg_per_100m = accuracy.fused.relative->rotation_deg_per_100m;
  }
}

}  // namespace

absl::Status WriteResults(const std::string& folder, const std::string& own,
                          MissionOutcome& outcome) {
  RETURN_IF_ERROR(WriteTrajectories(outcome, folder));
  ASSIGN_OR_RETURN(const Accuracy accuracy,
                   ComputeAccuracy(outcome.paths, outcome.report.from_frame, Alignment::kSe3));
  AddAccuracy(accuracy, outcome.report);
  RETURN_IF_ERROR(WriteLines({ToJson(outcome.report).dump(2)}, folder + "/report.json"));
  RETURN_IF_ERROR(WriteLines({ToMarkdown(outcome.report)}, folder + "/report.md"));
  ReportDetail detail = ComposeDetail(outcome.paths, outcome.map, own, accuracy);
  detail.held = ComposeHeld(outcome.paths, outcome.held, outcome.map);
  RETURN_IF_ERROR(WriteHeldPictures(detail.held, folder));
  detail.recorded = outcome.recorded;
  const ViewerPage page = LoadViewerPage(DefaultPagePath());
  RETURN_IF_ERROR(WriteLines({ToHtml(outcome.report, detail, page)}, folder + "/report.html"));
  return WritePicture(outcome, accuracy, own, folder + "/map.png");
}

}  // namespace corbslam::services

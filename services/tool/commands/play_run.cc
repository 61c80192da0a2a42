#include "services/tool/commands/play_run.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "client_agent/source/frame_reader.h"
#include "services/command_line/command_line.h"
#include "services/convert/resource_names.h"
#include "services/programs/robot/inspected_source.h"
#include "services/security/flags.h"
#include "services/tool/commands/run_results.h"
#include "services/tool/evaluation/accuracy.h"
#include "services/tool/evaluation/ground_truth.h"
#include "services/tool/evaluation/picture.h"
#include "services/tool/output/progress.h"
#include "services/tool/output/result.h"
#include "services/tool/run/run_folder.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FormatSourceSpec;
using client_agent::FrameReader;
using client_agent::FramesOf;
using client_agent::OpenReader;
using client_agent::SourceSpec;

namespace {

std::string DescribeStore(const MissionRunOptions& mission) {
  if (mission.pace == "step") return "in one process, in lockstep";
  return mission.server.empty() ? "with a map store of its own"
                                : absl::StrCat("on the map store ", mission.server);
}

std::vector<std::string> NamesOf(const std::vector<RobotPlan>& robots) {
  std::vector<std::string> names;
  for (const RobotPlan& robot : robots) names.push_back(robot.name);
  return names;
}

// Prints one line that a log without a terminal gets, too.
void SayStart(const RunPlan& plan) {
  Say(absl::StrCat("Mission ", plan.mission.mission, " ", DescribeStore(plan.mission), ": ",
                   absl::StrJoin(NamesOf(plan.mission.robots), ", "), " map ",
                   absl::StrJoin(plan.sources, ", "), plan.mission.alone ? ", each alone" : "",
                   "; results go to ", plan.out, "\n"));
}

std::string Describe(const Progress& progress) {
  std::string line = progress.stage;
  for (const auto& [name, frames] : progress.robots) {
    absl::StrAppend(&line, "  ", name, " ", frames);
  }
  return line;
}

// Checks what flags say together before anything starts.
absl::Status CheckFlags(const MissionRunOptions& mission) {
  if (mission.view && mission.pace == "step") {
    return absl::InvalidArgumentError(
        "--view shows what a map store has, and --pace step has none: take another pace");
  }
  if (!mission.server.empty() && mission.pace == "step") {
    return absl::InvalidArgumentError(absl::StrCat("--server is ", mission.server,
                                                   ", but --pace step plays robots and a map store "
                                                   "of their own in one process: leave --server "
                                                   "out, or take another pace"));
  }
  if (!mission.server.empty()) return MakeChannelCredentials(mission.security).status();
  const SecurityOptions& security = mission.security;
  if (security.certificate_file.empty() && security.key_file.empty() && security.ca_file.empty() &&
      security.token_file.empty()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      "--tls-cert, --tls-key, --tls-ca and --token-file are for a --server");
}

// Says what each source is. Returns warnings about what can be known to be wrong before the robots
// spend hours: sources that can't be opened and ground truth that can't be read.
absl::StatusOr<std::vector<ReportWarning>> CheckSources(const std::vector<RobotPlan>& robots,
                                                        bool strict) {
  std::vector<ReportWarning> warnings;
  std::set<std::string> seen;
  for (const RobotPlan& robot : robots) {
    SourceSpec whole = robot.source;
    whole.selection = {};
    if (!seen.insert(FormatSourceSpec(whole)).second) continue;
    ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(whole));
    RETURN_IF_ERROR(JudgeFindings(reader->description().remarks.findings, strict));
    ASSIGN_OR_RETURN(const std::optional<GroundTruth> truth, ReadGroundTruth(whole));
    if (truth.has_value()) {
      for (const std::string& note : truth->notes) warnings.push_back({"", "ground-truth", note});
    }
    Say(absl::StrCat(FormatSourceSpec(whole), "\n", FormatDescription(reader->description()),
                     "\n"));
  }
  if (!strict || warnings.empty()) return warnings;
  return absl::InvalidArgumentError(warnings.front().text);
}

// Writes the truth for a viewer. Returns the file; an empty name where there is none, or where the
// robots did not go one way, so that their truths need not be in one frame.
absl::StatusOr<std::string> WriteTruth(const std::vector<RobotPlan>& robots,
                                       const std::string& folder) {
  std::map<std::string, Trajectory> truths;  // By the sequence.
  for (const RobotPlan& robot : robots) {
    if (WayOf(robot.source) != WayOf(robots.front().source)) return "";
    SourceSpec whole = robot.source;
    whole.selection = {};
    const std::string name = FormatSourceSpec(whole);
    if (truths.contains(name)) continue;
    ASSIGN_OR_RETURN(std::optional<GroundTruth> truth, ReadGroundTruth(whole));
    if (!truth.has_value()) return "";
    truths[name] = std::move(truth->trajectory);
  }
  std::vector<Trajectory> parts;
  for (auto& [name, truth] : truths) parts.push_back(std::move(truth));
  const std::string path = absl::StrCat(folder, "/truth.tum");
  RETURN_IF_ERROR(WriteTumTrajectory(MergeByTime(parts), path));
  return path;
}

// Returns an error if a robot failed, although the report is written. Those that played alone count
// as further ones.
absl::Status JudgeOutcome(const MissionOutcome& outcome, const std::string& out) {
  if (outcome.failures.empty()) return absl::OkStatus();
  const size_t played = outcome.report.robots.size() * (outcome.report.company.has_value() ? 2 : 1);
  return absl::FailedPreconditionError(absl::StrCat(outcome.failures.size(), " of ", played,
                                                    " robots failed; the report of all is in ", out,
                                                    ".\n", absl::StrJoin(outcome.failures, "\n")));
}

absl::StatusOr<MissionOutcome> PlayRobots(const MissionRunOptions& mission) {
  ProgressLine line;
  const auto on_progress = [&line](const Progress& progress) { line.Tell(Describe(progress)); };
  return mission.pace == "step" ? RunLockstep(mission, on_progress)
                                : RunProcesses(mission, on_progress);
}

// Plays the robots, and fills in what the plan knows of the report. `start` is when the run began.
absl::StatusOr<MissionOutcome> Play(const RunPlan& plan, absl::Time start) {
  SayStart(plan);
  absl::StatusOr<MissionOutcome> outcome = PlayRobots(plan.mission);
  RETURN_IF_ERROR(outcome.status());
  RunReport& report = outcome->report;
  report.mission = plan.mission.mission;
  report.pace = plan.mission.pace;
  report.from_frame = plan.from_frame;
  report.version = ProgramVersion();
  report.command = plan.command_line;
  report.wall_s = absl::ToDoubleSeconds(absl::Now() - start);
  return outcome;
}

std::string AloneName(const std::string& mission) { return mission + "-alone"; }

// Returns the plan of the same robots alone.
RunPlan PlanAlone(RunPlan plan) {
  plan.mission.alone = true;
  plan.mission.view = false;
  plan.mission.mission = AloneName(plan.mission.mission);
  plan.out += "/alone";
  plan.mission.log_folder = plan.out + "/logs";
  return plan;
}

// Plays the robots alone, writes that run's own results, and adds to the first one's what company
// gave.
absl::Status AddCompany(const RunPlan& plan, MissionOutcome& outcome) {
  const RunPlan alone = PlanAlone(plan);
  RETURN_IF_ERROR(MakeFolder(alone.mission.log_folder));
  ASSIGN_OR_RETURN(MissionOutcome apart, Play(alone, absl::Now()));
  RETURN_IF_ERROR(WriteResults(alone.out, alone.own, apart));
  CompanyReport& company = outcome.report.company.emplace();
  company.alone = apart.report.robots;
  for (size_t i = 0; i < company.alone.size(); ++i) {
    ASSIGN_OR_RETURN(const ToldAccuracy told,
                     ComputeToldAccuracy(apart.paths[i], outcome.paths[i].told, Alignment::kSe3));
    company.alone[i].told_ate_m = told.ate_m;
    company.alone[i].told_ate_before_m = told.ate_before_m;
  }
  company.fused_ate_alone_m = apart.report.fused.ate_m;
  company.wall_s = apart.report.wall_s;
  for (const std::string& failure : apart.failures) outcome.failures.push_back("alone: " + failure);
  return absl::OkStatus();
}

// Checks what flags say before anything starts.
absl::Status CheckPlan(const RunPlan& plan) {
  RETURN_IF_ERROR(CheckNameSegment("--mission", plan.mission.mission));
  if (plan.company) {
    RETURN_IF_ERROR(
        CheckNameSegment("--company's second mission", AloneName(plan.mission.mission)));
  }
  return CheckFlags(plan.mission);
}

void PrintWarnings(const RunReport& report) {
  for (const ReportWarning& warning : AllWarnings(report)) {
    std::fprintf(stderr, "warning: %s%s%s [%s]\n", warning.robot.c_str(),
                 warning.robot.empty() ? "" : ": ", warning.text.c_str(), warning.code.c_str());
  }
}

// A page that was open says no more than that the connection broke.
void SayThatTheViewEnded(const RunPlan& plan) {
  const std::string where =
      plan.mission.server.empty()
          ? absl::StrCat("open ", plan.out, "/report.html to look further")
          : absl::StrCat("map_viewer --store ", plan.mission.server, " shows the mission further");
  Say(absl::StrCat("The page of --view ended with the run; ", where, ".\n"));
}

// Refuses a frame from which on nothing is counted, if somebody named one.
absl::Status CheckFromFrame(const RunPlan& plan) {
  if (!plan.is_from_frame_given) return absl::OkStatus();
  size_t last = 0;
  for (const RobotPlan& robot : plan.mission.robots) {
    ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(robot.source));
    for (const size_t frame : FramesOf(robot.source, reader->frame_count())) {
      last = std::max(last, frame);
    }
  }
  if (plan.from_frame <= last) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("--from-frame is ", plan.from_frame,
                                                 ", and the last frame that is played is ", last));
}

}  // namespace

absl::Status PlayRun(RunPlan plan) {
  const absl::Time start = absl::Now();
  RETURN_IF_ERROR(CheckPlan(plan));
  ASSIGN_OR_RETURN(plan.own, ChooseOwn(plan.own, NamesOf(plan.mission.robots)));
  ASSIGN_OR_RETURN(std::vector<ReportWarning> warnings,
                   CheckSources(plan.mission.robots, plan.mission.strict));
  RETURN_IF_ERROR(CheckFromFrame(plan));
  // Both runs have the same seed; in lockstep it is the one of every run.
  if (plan.company && plan.mission.pace != "step" && !plan.mission.seed.has_value()) {
    plan.mission.seed = std::random_device()() | 1u;
  }
  ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Take(plan.out, plan.command_line));
  plan.mission.log_folder = plan.out + "/logs";
  if (plan.mission.view) {
    ASSIGN_OR_RETURN(plan.mission.truth_path,
                     WriteTruth(plan.mission.robots, plan.mission.log_folder));
  }
  ASSIGN_OR_RETURN(MissionOutcome outcome, Play(plan, start));
  outcome.report.warnings = std::move(warnings);
  RETURN_IF_ERROR(WriteResults(plan.out, plan.own, outcome));
  if (plan.company) {
    // The first results stand whatever becomes of the second run.
    RETURN_IF_ERROR(AddCompany(plan, outcome));
    RETURN_IF_ERROR(WriteResults(plan.out, plan.own, outcome));
  }
  PrintResult(absl::StrFormat("Done in %.0f s: %s/report.md, report.html, report.json, map.png\n",
                              absl::ToDoubleSeconds(absl::Now() - start), plan.out),
              ToJson(outcome.report));
  if (plan.mission.view) SayThatTheViewEnded(plan);
  if (!WantsJson()) PrintWarnings(outcome.report);
  return JudgeOutcome(outcome, plan.out);
}

}  // namespace corbslam::services

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_kinds.h"
#include "services/command_line/command_line.h"
#include "services/convert/resource_names.h"
#include "services/programs/robot/inspected_source.h"
#include "services/security/flags.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/run_results.h"
#include "services/tool/evaluation/ground_truth.h"
#include "services/tool/evaluation/picture.h"
#include "services/tool/run/mission_run.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FormatSourceSpec;
using client_agent::FrameReader;
using client_agent::OpenReader;
using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;
using client_agent::SourceUsage;

namespace {

struct RunArguments {
  std::vector<std::string> sources;
  size_t robots = 0;
  size_t overlap = 20;
  std::string split = "halves";
  std::vector<std::string> perturbations;
  std::string own;
  std::string out = "out/run";
  size_t from_frame = 15;
  MissionRunOptions mission;
  std::string command_line;
};

absl::StatusOr<std::vector<RobotPlan>> Plan(const RunArguments& arguments) {
  PlanOptions plan;
  for (const std::string& text : arguments.sources) {
    ASSIGN_OR_RETURN(plan.sources.emplace_back(), ParseSourceSpec(text));
  }
  if (arguments.sources.size() > 1 && arguments.robots != 0 &&
      arguments.robots != arguments.sources.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--robots ", arguments.robots, " with ", arguments.sources.size(),
                     " sources: one source is split, or each robot has a source of its own"));
  }
  plan.split.robots = arguments.robots == 0 ? 2 : arguments.robots;
  plan.split.overlap = arguments.overlap;
  plan.split.mode = arguments.split == "interleaved" ? SplitMode::kInterleaved : SplitMode::kHalves;
  for (const std::string& text : arguments.perturbations) {
    ASSIGN_OR_RETURN(auto perturbation, ParsePerturbation(text));
    plan.perturbations.insert(std::move(perturbation));
  }
  return PlanRobots(plan);
}

std::string DescribeStore(const MissionRunOptions& mission) {
  if (mission.pace == "step") return "in one process, in lockstep";
  return mission.server.empty() ? "with a map store of its own"
                                : absl::StrCat("on the map store ", mission.server);
}

// Prints one line that a log without a terminal gets, too.
void SayStart(const RunArguments& arguments, const std::vector<std::string>& names) {
  std::printf(
      "%s\n",
      absl::StrCat("Mission ", arguments.mission.mission, " ", DescribeStore(arguments.mission),
                   ": ", absl::StrJoin(names, ", "), " map ",
                   absl::StrJoin(arguments.sources, ", "), "; results go to ", arguments.out)
          .c_str());
  std::fflush(stdout);
}

std::vector<std::string> NamesOf(const std::vector<RobotPlan>& robots) {
  std::vector<std::string> names;
  for (const RobotPlan& robot : robots) names.push_back(robot.name);
  return names;
}

// Prints one line that is written over, which is for a terminal only.
void ShowOnTerminal(const Progress& progress) {
  std::string line = progress.stage;
  for (const auto& [name, frames] : progress.robots)
    absl::StrAppend(&line, "  ", name, " ", frames);
  std::fprintf(stderr, "\r%-78s", line.substr(0, 78).c_str());
}

// Checks what flags say together before anything starts.
absl::Status CheckFlags(const MissionRunOptions& mission) {
  if (mission.view && mission.pace == "step") {
    return absl::InvalidArgumentError(
        "--view shows what a map store has, and --pace step has none: take another pace");
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
    std::printf("%s\n%s\n", FormatSourceSpec(whole).c_str(),
                FormatDescription(reader->description()).c_str());
  }
  if (!strict || warnings.empty()) return warnings;
  return absl::InvalidArgumentError(warnings.front().text);
}

// Writes the truth for a viewer. Returns the file; an empty name where there is none, or where the
// robots are on sequences of their own, whose truths need not be in one frame.
absl::StatusOr<std::string> WriteTruth(const std::vector<RobotPlan>& robots,
                                       const std::string& folder) {
  std::set<std::string> sources;
  SourceSpec whole;
  for (const RobotPlan& robot : robots) {
    whole = robot.source;
    whole.selection = {};
    sources.insert(FormatSourceSpec(whole));
  }
  if (sources.size() != 1) return "";
  ASSIGN_OR_RETURN(const std::optional<GroundTruth> truth, ReadGroundTruth(whole));
  if (!truth.has_value()) return "";
  const std::string path = absl::StrCat(folder, "/truth.tum");
  RETURN_IF_ERROR(WriteTumTrajectory(truth->trajectory, path));
  return path;
}

// Returns an error if a robot failed, although the report is written.
absl::Status JudgeOutcome(const MissionOutcome& outcome, const std::string& out) {
  if (outcome.failures.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(outcome.failures.size(), " of ",
                                                    outcome.report.robots.size(),
                                                    " robots failed; the report of all is in ", out,
                                                    ".\n", absl::StrJoin(outcome.failures, "\n")));
}

absl::Status Run(RunArguments arguments) {
  const absl::Time start = absl::Now();
  RETURN_IF_ERROR(CheckNameSegment("--mission", arguments.mission.mission));
  RETURN_IF_ERROR(CheckFlags(arguments.mission));
  ASSIGN_OR_RETURN(arguments.mission.robots, Plan(arguments));
  const std::vector<std::string> names = NamesOf(arguments.mission.robots);
  ASSIGN_OR_RETURN(arguments.own, ChooseOwn(arguments.own, names));
  ASSIGN_OR_RETURN(std::vector<ReportWarning> warnings,
                   CheckSources(arguments.mission.robots, arguments.mission.strict));
  arguments.mission.log_folder = arguments.out + "/logs";
  RETURN_IF_ERROR(MakeFolder(arguments.mission.log_folder));
  if (arguments.mission.view) {
    ASSIGN_OR_RETURN(arguments.mission.truth_path,
                     WriteTruth(arguments.mission.robots, arguments.mission.log_folder));
  }
  SayStart(arguments, names);
  const bool is_terminal = isatty(STDERR_FILENO) != 0;
  const ProgressListener on_progress = is_terminal ? ShowOnTerminal : ProgressListener();
  absl::StatusOr<MissionOutcome> outcome = arguments.mission.pace == "step"
                                               ? RunLockstep(arguments.mission, on_progress)
                                               : RunProcesses(arguments.mission, on_progress);
  if (is_terminal) std::fprintf(stderr, "\r%-78s\r", "");
  RETURN_IF_ERROR(outcome.status());
  RunReport& report = outcome->report;
  report.warnings = std::move(warnings);
  report.mission = arguments.mission.mission;
  report.pace = arguments.mission.pace;
  report.from_frame = arguments.from_frame;
  report.version = ProgramVersion();
  report.command = arguments.command_line;
  report.wall_s = absl::ToDoubleSeconds(absl::Now() - start);
  RETURN_IF_ERROR(WriteResults(arguments.out, arguments.own, *outcome));
  std::printf("Done in %.0f s: %s/report.md, report.html, report.json, map.png\n", report.wall_s,
              arguments.out.c_str());
  for (const ReportWarning& warning : AllWarnings(report)) {
    std::fprintf(stderr, "warning: %s%s%s [%s]\n", warning.robot.c_str(),
                 warning.robot.empty() ? "" : ": ", warning.text.c_str(), warning.code.c_str());
  }
  return JudgeOutcome(*outcome, arguments.out);
}

void AddMissionOptions(CLI::App& run, RunArguments& arguments) {
  MissionRunOptions& mission = arguments.mission;
  run.add_option("--pace", mission.pace,
                 "sensor: as recorded, frames that come too fast are dropped; max: as fast as the "
                 "robots go; step: deterministic, in one process")
      ->check(CLI::IsMember({"sensor", "max", "step"}))
      ->capture_default_str();
  run.add_flag("--strict", mission.strict,
               "Refuse sources in which something looks wrong, instead of warning");
  run.add_flag("--view", mission.view,
               "Show the map in browsers while it grows; prints the address");
  run.add_flag("--sequential", mission.sequential, "One robot after the other");
  run.add_option("--server", mission.server, "A running map store, HOST:PORT; else one is started");
  AddTlsFlags(run, mission.security);
  AddClientFlags(run, mission.security);
  run.add_option("--mission", mission.mission, "Name of the mission")->capture_default_str();
  run.add_option("--seed", mission.seed, "Of every random choice")->capture_default_str();
  run.add_option("--vocabulary", mission.vocabulary_path, "Instead of the one that ships");
}

}  // namespace

void AddRunCommand(CLI::App& app, const std::string& command_line, Command& chosen) {
  auto arguments = std::make_shared<RunArguments>();
  arguments->command_line = command_line;
  CLI::App* run = app.add_subcommand("run", "Let robots map sequences together");
  run->add_option("--source", arguments->sources,
                  SourceUsage() + ", each with ?OPTIONS; several: one robot each")
      ->required();
  run->add_option("--robots", arguments->robots, "Among how many one source is split (2)");
  run->add_option("--overlap", arguments->overlap, "Frames by which parts reach beyond their share")
      ->capture_default_str();
  run->add_option("--split", arguments->split, "halves, or interleaved: every n-th frame of a part")
      ->check(CLI::IsMember({"halves", "interleaved"}))
      ->capture_default_str();
  run->add_option("--perturb", arguments->perturbations,
                  "What robot N sees differently, as 2:gamma=0.8,noise=4,reverse");
  run->add_option("--own", arguments->own, "The robot drawn as own (the first)");
  run->add_option("--from-frame", arguments->from_frame,
                  "Errors are given also from this frame of the sequence on")
      ->capture_default_str();
  run->add_option("--out", arguments->out, "Folder for all results")->capture_default_str();
  AddMissionOptions(*run, *arguments);
  run->callback([arguments, &chosen] { chosen = [arguments] { return Run(*arguments); }; });
}

void AddDemoCommand(CLI::App& app, const std::string& command_line, Command& chosen) {
  auto arguments = std::make_shared<RunArguments>();
  arguments->command_line = command_line;
  arguments->sources = {"sim:city?seed=7&length=400"};
  arguments->out = "out/demo";
  CLI::App* demo =
      app.add_subcommand("demo", "Two robots map a simulated town together: try this first");
  demo->add_option("--source", arguments->sources[0], "Another sequence, as for run")
      ->capture_default_str();
  demo->add_option("--out", arguments->out, "Folder for all results")->capture_default_str();
  demo->add_flag("--view", arguments->mission.view,
                 "Show the map in browsers while it grows; prints the address");
  demo->callback([arguments, &chosen] {
    chosen = [arguments]() -> absl::Status {
      RETURN_IF_ERROR(Run(*arguments));
      std::ifstream report(arguments->out + "/report.md");
      std::cout << "\n"
                << report.rdbuf() << "\nthe map: " << arguments->out
                << "/map.png\nto look at: " << arguments->out << "/report.html\n";
      return absl::OkStatus();
    };
  });
}

}  // namespace corbslam::services

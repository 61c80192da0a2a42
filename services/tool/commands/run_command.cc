#include <fstream>
#include <iostream>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/source_kinds.h"
#include "services/security/flags.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/play_run.h"
#include "services/tool/output/result.h"
#include "services/tool/run/mission_run.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::ParseSourceSpec;
using client_agent::SourceUsage;

namespace {

// The demo's robots meet while they drive: each goes two thirds of the way round, so that alpha
// follows bravo through the second third of it, some 13 s behind, and bravo ends where alpha began.
// Bravo takes its pictures half way between alpha's, through a camera of other noise.
constexpr char kDemoSource[] = "sim:city?seed=7&length=400";
constexpr size_t kDemoOverlap = 130;
constexpr char kDemoPerturbation[] = "2:phase=0.5,noise_seed=2";

struct RunArguments {
  RunPlan plan;  // Without robots.
  size_t robots = 0;
  size_t overlap = 20;
  std::string split = "halves";
  std::string truth_frame = "own";
  std::vector<std::string> perturbations;
};

absl::StatusOr<std::vector<RobotPlan>> PlanOf(const RunArguments& arguments) {
  PlanOptions plan;
  for (const std::string& text : arguments.plan.sources) {
    ASSIGN_OR_RETURN(plan.sources.emplace_back(), ParseSourceSpec(text));
  }
  if (arguments.plan.sources.size() > 1 && arguments.robots != 0 &&
      arguments.robots != arguments.plan.sources.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--robots ", arguments.robots, " with ", arguments.plan.sources.size(),
                     " sources: one source is split, or each robot has a source of its own"));
  }
  plan.is_truth_shared = arguments.truth_frame == "shared";
  plan.split.robots = arguments.robots == 0 ? 2 : arguments.robots;
  plan.split.overlap = arguments.overlap;
  plan.split.mode = arguments.split == "interleaved" ? SplitMode::kInterleaved : SplitMode::kHalves;
  for (const std::string& text : arguments.perturbations) {
    ASSIGN_OR_RETURN(auto perturbation, ParsePerturbation(text));
    plan.perturbations.insert(std::move(perturbation));
  }
  return PlanRobots(plan);
}

absl::Status Run(RunArguments arguments) {
  ASSIGN_OR_RETURN(arguments.plan.mission.robots, PlanOf(arguments));
  return PlayRun(std::move(arguments.plan));
}

void AddCompanyFlag(CLI::App& app, RunPlan& plan) {
  app.add_flag("--company", plan.company,
               "Play the robots once more, alone, and report what company gave");
}

void AddMissionOptions(CLI::App& run, MissionRunOptions& mission) {
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
  arguments->plan.command_line = command_line;
  arguments->plan.out = "out/run";
  CLI::App* run = app.add_subcommand("run", "Let robots map sequences together");
  run->add_option("--source", arguments->plan.sources,
                  SourceUsage() + ", each with ?OPTIONS; several: one robot each")
      ->required();
  run->add_option("--robots", arguments->robots, "Among how many one source is split (2)")
      ->check(CLI::Range(1, 100));
  run->add_option("--overlap", arguments->overlap, "Frames by which parts reach beyond their share")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  run->add_option("--split", arguments->split, "halves, or interleaved: every n-th frame of a part")
      ->check(CLI::IsMember({"halves", "interleaved"}))
      ->capture_default_str();
  run->add_option("--truth-frame", arguments->truth_frame,
                  "own: each sequence's truth has a frame of its own, if ?truth_frame= does not "
                  "say otherwise; shared: all are in one, as of recordings of one room, and the "
                  "fused error is of all")
      ->check(CLI::IsMember({"own", "shared"}))
      ->capture_default_str();
  run->add_option("--perturb", arguments->perturbations,
                  "What robot N sees differently, as 2:gamma=0.8,noise=4,reverse");
  run->add_option("--own", arguments->plan.own, "The robot drawn as own (the first)");
  const CLI::Option* const from_frame =
      run->add_option("--from-frame", arguments->plan.from_frame,
                      "Errors are given also from this frame of the sequence on")
          ->check(CLI::Range(0, 1'000'000'000))
          ->capture_default_str();
  run->add_option("--out", arguments->plan.out, "Folder for all results")->capture_default_str();
  AddCompanyFlag(*run, arguments->plan);
  AddMissionOptions(*run, arguments->plan.mission);
  run->callback([arguments, from_frame, &chosen] {
    arguments->plan.is_from_frame_given = from_frame->count() > 0;
    chosen = [arguments] { return Run(*arguments); };
  });
}

void AddDemoCommand(CLI::App& app, const std::string& command_line, Command& chosen) {
  auto arguments = std::make_shared<RunArguments>();
  arguments->plan.command_line = command_line;
  arguments->plan.sources = {kDemoSource};
  arguments->plan.out = "out/demo";
  CLI::App* demo =
      app.add_subcommand("demo", "Two robots map a simulated town together: try this first");
  const CLI::Option* source =
      demo->add_option("--source", arguments->plan.sources[0],
                       "Another sequence, as for run, of which each robot plays a half")
          ->capture_default_str();
  demo->add_option("--out", arguments->plan.out, "Folder for all results")->capture_default_str();
  AddCompanyFlag(*demo, arguments->plan);
  demo->add_flag("--view", arguments->plan.mission.view,
                 "Show the map in browsers while it grows; prints the address");
  demo->callback([arguments, source, &chosen] {
    if (source->count() == 0) {
      arguments->overlap = kDemoOverlap;
      arguments->perturbations = {kDemoPerturbation};
    }
    chosen = [arguments]() -> absl::Status {
      RETURN_IF_ERROR(Run(*arguments));
      if (WantsJson()) return absl::OkStatus();
      std::ifstream report(arguments->plan.out + "/report.md");
      std::cout << "\n"
                << report.rdbuf() << "\nthe map: " << arguments->plan.out
                << "/map.png\nto look at: " << arguments->plan.out << "/report.html\n";
      return absl::OkStatus();
    };
  });
}

}  // namespace corbslam::services

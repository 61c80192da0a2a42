#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client_agent/source/frame_reader.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/progress.h"
#include "services/tool/output/result.h"
#include "services/tool/run/plan.h"
#include "services/tool/sequence/sequence_writer.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FormatSourceSpec;
using client_agent::FrameReader;
using client_agent::FramesOf;
using client_agent::OpenReader;
using client_agent::ParseSourceSpec;
using client_agent::SourceLayout;
using client_agent::SourceSpec;
using client_agent::UseRig;

namespace {

struct SimulateArguments {
  std::string source;
  std::string rig;
  std::string layout = "kitti";
  std::string out;
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
};

struct SplitArguments {
  SimulateArguments simulate;
  size_t robots = 2;
  size_t overlap = 20;
};

SourceLayout LayoutOf(const std::string& name) {
  if (name == "euroc") return SourceLayout::kEuroc;
  return name == "tum" ? SourceLayout::kTum : SourceLayout::kKitti;
}

// Returns what was written, as JSON.
absl::StatusOr<nlohmann::ordered_json> Write(const SourceSpec& source,
                                             const SimulateArguments& arguments,
                                             const std::string& folder) {
  WriteSequenceOptions options;
  options.layout = LayoutOf(arguments.layout);
  options.folder = folder;
  options.threads = arguments.threads;
  const absl::Time start = absl::Now();
  ProgressLine progress;
  options.on_progress = [&progress, start](size_t done, size_t total) {
    progress.Tell(DescribeCount(done, total, "frames", absl::Now() - start));
  };
  RETURN_IF_ERROR(CheckNewFolder(folder));
  ASSIGN_OR_RETURN(const size_t frames, WriteSequence(source, options));
  const double elapsed_s = absl::ToDoubleSeconds(absl::Now() - start);
  Say(absl::StrFormat("%s: %d frames in %.1f s, %.1f frames/s\n", folder, frames, elapsed_s,
                      static_cast<double>(frames) / elapsed_s));
  return nlohmann::ordered_json{{"folder", folder}, {"frames", frames}, {"seconds", elapsed_s}};
}

absl::Status Simulate(const SimulateArguments& arguments) {
  ASSIGN_OR_RETURN(SourceSpec source, ParseSourceSpec(arguments.source));
  if (!arguments.rig.empty()) RETURN_IF_ERROR(UseRig(arguments.rig, source));
  ASSIGN_OR_RETURN(const nlohmann::ordered_json json, Write(source, arguments, arguments.out));
  PrintResult("", json);
  return absl::OkStatus();
}

absl::StatusOr<nlohmann::ordered_json> DescribePart(const RobotPlan& robot) {
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(robot.source));
  const std::vector<size_t> frames = FramesOf(robot.source, reader->frame_count());
  const double start_s = 1e-9 * static_cast<double>(reader->timestamp_ns(frames.front()));
  Say(absl::StrFormat("%-10s %6d %6d %6d %12.3f %s\n", robot.name, frames.front(), frames.back(),
                      frames.size(), start_s, FormatSourceSpec(robot.source)));
  return nlohmann::ordered_json{
      {"robot", robot.name},   {"first", frames.front()},
      {"last", frames.back()}, {"frames", frames.size()},
      {"start_s", start_s},    {"source", FormatSourceSpec(robot.source)}};
}

absl::Status Split(const SplitArguments& arguments) {
  PlanOptions options;
  ASSIGN_OR_RETURN(options.sources.emplace_back(), ParseSourceSpec(arguments.simulate.source));
  options.split.robots = arguments.robots;
  options.split.overlap = arguments.overlap;
  ASSIGN_OR_RETURN(const std::vector<RobotPlan> robots, PlanRobots(options));
  Say(absl::StrFormat("%-10s %6s %6s %6s %12s %s\n", "robot", "first", "last", "frames", "start, s",
                      "source"));
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const RobotPlan& robot : robots) {
    ASSIGN_OR_RETURN(rows.emplace_back(), DescribePart(robot));
  }
  for (size_t i = 0; i < robots.size() && !arguments.simulate.out.empty(); ++i) {
    const std::string folder = absl::StrCat(arguments.simulate.out, "/", robots[i].name);
    ASSIGN_OR_RETURN(rows[i]["written"], Write(robots[i].source, arguments.simulate, folder));
  }
  PrintResult("", rows);
  return absl::OkStatus();
}

void AddWriteOptions(CLI::App& app, SimulateArguments& arguments) {
  app.add_option("--layout", arguments.layout, "Of the files: kitti, euroc or tum")
      ->check(CLI::IsMember({"kitti", "euroc", "tum"}))
      ->capture_default_str();
  app.add_option("--threads", arguments.threads, "Frames drawn at a time; changes speed only")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
}

}  // namespace

void AddSimulateCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* simulate = app.add_subcommand(
      "simulate", "Write a simulated sequence with calibration and ground truth");
  simulate->add_option("--source", arguments->source, "sim:city, sim:path or sim:floor, ?OPTIONS")
      ->required();
  simulate->add_option("--rig", arguments->rig, "Draw through the lenses of this rig file");
  simulate->add_option("--out", arguments->out, "Folder of the sequence")->required();
  AddWriteOptions(*simulate, *arguments);
  simulate->callback(
      [arguments, &chosen] { chosen = [arguments] { return Simulate(*arguments); }; });
}

void AddSplitCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<SplitArguments>();
  CLI::App* split = app.add_subcommand(
      "split", "The parts of a sequence that robots play, as in the paper's experiments");
  split->add_option("--source", arguments->simulate.source, "The whole sequence")->required();
  split->add_option("--robots", arguments->robots, "Among how many")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  split
      ->add_option("--overlap", arguments->overlap,
                   "Frames by which parts reach beyond their share")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  split->add_option("--out", arguments->simulate.out,
                    "Write a simulation's parts, each to a folder in this one");
  AddWriteOptions(*split, arguments->simulate);
  split->callback([arguments, &chosen] { chosen = [arguments] { return Split(*arguments); }; });
}

}  // namespace corbslam::services

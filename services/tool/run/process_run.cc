#include <glog/logging.h>
#include <grpcpp/channel.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/source/frame_reader.h"
#include "corbslam/v1/agent_service.grpc.pb.h"
#include "services/client/remote/channel.h"
#include "services/programs/robot/held_map_file.h"
#include "services/programs/robot/robot_report.h"
#include "services/programs/robot/told_poses.h"
#include "services/runtime/child_process.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/output/result.h"
#include "services/tool/run/mission_run.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FormatSourceSpec;
using client_agent::FrameReader;
using client_agent::FramesOf;
using client_agent::NearMap;
using client_agent::OpenReader;

namespace {

constexpr absl::Duration kStartTimeout = absl::Seconds(60);
constexpr absl::Duration kStopGrace = absl::Seconds(10);
constexpr absl::Duration kProgressInterval = absl::Seconds(1);
constexpr absl::Duration kAskAgain = absl::Milliseconds(100);
constexpr absl::Duration kSharingTimeout = absl::Seconds(30);
constexpr absl::Duration kAgentStopGrace = absl::Seconds(60);

struct RunningAgent {
  RobotPlan plan;
  size_t frames = 0;
  std::string statistics_path;
  std::string held_map_path;
  std::string told_stem;
  std::unique_ptr<ChildProcess> process;
  std::string address;                    // Empty if it does not serve.
  std::unique_ptr<v1::Agent::Stub> stub;  // Null if the agent does not stay after its last frame.
  absl::Status failure;                   // How the process ended, if that was no success.
};

class ProcessRun {
 public:
  ProcessRun(const MissionRunOptions& options, const ProgressListener& on_progress)
      : options_(options), on_progress_(on_progress) {}

  absl::StatusOr<MissionOutcome> Run();

 private:
  // Returns the program's path, then the arguments, then the vocabulary if one is needed and named.
  absl::StatusOr<std::vector<std::string>> MakeCommand(const std::string& program,
                                                       std::vector<std::string> arguments,
                                                       bool needs_vocabulary) const;
  absl::StatusOr<std::string> StartServer(const std::string& program,
                                          std::vector<std::string> arguments,
                                          bool needs_vocabulary);
  // The store has a journal where somebody may want to see the map's past.
  absl::Status StartServers();
  // Returns the path of a file or folder of the logs' that is not there: what an earlier run left
  // is removed.
  absl::StatusOr<std::string> MakeFreshPath(const std::string& name) const;
  // Starts a viewer of the mission, which also asks the agents that run, and says where it is.
  absl::Status StartViewer();
  // Starts an agent. With `stays` it is connected until it is stopped, and takes in what others
  // made.
  absl::Status StartAgent(const RobotPlan& plan, bool stays);
  // Waits until every agent that was started has mapped its last frame.
  void WaitForAgents();
  // Waits until the agents that stay have what the store has for them.
  absl::Status WaitUntilShared();
  // Returns whether the agent has all that the store has for it, by what the store and the agent
  // say.
  bool KnowsAll(const RunningAgent& agent,
                const std::map<std::string, v1::MissionAgent>& at_store) const;
  void StopAgents();
  absl::Status WaitUntilFused();
  void ShowProgress(const std::string& stage);
  void StopServers(MissionOutcome& outcome);

  const MissionRunOptions& options_;
  const ProgressListener& on_progress_;
  std::string store_address_;
  std::vector<std::unique_ptr<ChildProcess>> servers_;
  std::vector<RunningAgent> agents_;
  std::unique_ptr<StoreReader> store_;
};

absl::StatusOr<std::vector<std::string>> ProcessRun::MakeCommand(const std::string& program,
                                                                 std::vector<std::string> arguments,
                                                                 bool needs_vocabulary) const {
  ASSIGN_OR_RETURN(const std::string path, FindProgramBeside(program));
  arguments.insert(arguments.begin(), path);
  if (needs_vocabulary && !options_.vocabulary_path.empty()) {
    arguments.insert(arguments.end(), {"--vocabulary", options_.vocabulary_path});
  }
  return arguments;
}

absl::StatusOr<std::string> ProcessRun::StartServer(const std::string& program,
                                                    std::vector<std::string> arguments,
                                                    bool needs_vocabulary) {
  arguments.insert(arguments.end(), {"--listen", "127.0.0.1:0", "--insecure"});
  ASSIGN_OR_RETURN(const std::vector<std::string> command,
                   MakeCommand(program, std::move(arguments), needs_vocabulary));
  ASSIGN_OR_RETURN(std::unique_ptr<ChildProcess> server,
                   ChildProcess::Start(program, command,
                                       absl::StrCat(options_.log_folder, "/", program, ".log")));
  servers_.push_back(std::move(server));
  return servers_.back()->WaitForAddress(kStartTimeout);
}

absl::Status ProcessRun::StartServers() {
  store_address_ = options_.server;
  if (!store_address_.empty()) {
    ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> channel,
                     ConnectToStoreOf(options_.mission, store_address_, options_.security));
    store_ = std::make_unique<StoreReader>(std::move(channel), options_.mission);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const std::string worker, StartServer("fusion_worker", {}, false));
  // The report is of all that the robots made.
  std::vector<std::string> arguments = {"--worker", worker, "--keep-everything"};
  if (options_.view) {
    ASSIGN_OR_RETURN(const std::string folder, MakeFreshPath("missions"));
    arguments.insert(arguments.end(), {"--data-dir", folder});
  }
  ASSIGN_OR_RETURN(store_address_, StartServer("map_store", std::move(arguments), true));
  return absl::OkStatus();
}

absl::StatusOr<std::string> ProcessRun::MakeFreshPath(const std::string& name) const {
  const std::string path = absl::StrCat(options_.log_folder, "/", name);
  std::error_code error;
  std::filesystem::remove_all(path, error);
  if (error) return absl::UnavailableError(absl::StrCat(path, ": ", error.message()));
  return path;
}

void AppendFlags(const SecurityOptions& security, std::vector<std::string>& arguments) {
  if (security.insecure) arguments.push_back("--insecure");
  for (const auto& [flag, value] : {std::pair("--tls-cert", security.certificate_file),
                                    {"--tls-key", security.key_file},
                                    {"--tls-ca", security.ca_file},
                                    {"--token-file", security.token_file}}) {
    if (!value.empty()) arguments.insert(arguments.end(), {flag, value});
  }
}

absl::Status ProcessRun::StartViewer() {
  std::vector<std::string> arguments = {"--store", store_address_, "--listen", "127.0.0.1:0"};
  if (!options_.truth_path.empty()) {
    arguments.insert(arguments.end(),
                     {"--truth", absl::StrCat(options_.mission, "=", options_.truth_path)});
  }
  if (options_.server.empty()) {
    arguments.push_back("--insecure");
    for (const RunningAgent& agent : agents_) {
      if (agent.address.empty()) continue;
      arguments.insert(
          arguments.end(),
          {"--robot", absl::StrCat(options_.mission, "/", agent.plan.name, "=", agent.address)});
    }
  } else {
    arguments.push_back("--open");
    AppendFlags(options_.security, arguments);
  }
  ASSIGN_OR_RETURN(const std::vector<std::string> command,
                   MakeCommand("map_viewer", std::move(arguments), false));
  ASSIGN_OR_RETURN(std::unique_ptr<ChildProcess> viewer,
                   ChildProcess::Start("map_viewer", command,
                                       absl::StrCat(options_.log_folder, "/map_viewer.log")));
  servers_.push_back(std::move(viewer));
  ASSIGN_OR_RETURN(const std::string address, servers_.back()->WaitForAddress(kStartTimeout));
  // Who wants JSON is told beside it.
  std::FILE* const out = WantsJson() ? stderr : stdout;
  std::fprintf(out, "Look: http://%s/#mission=%s\n", address.c_str(), options_.mission.c_str());
  std::fflush(out);
  return absl::OkStatus();
}

// Returns the program that plays the source: client_agent knows no simulator.
std::string AgentProgram(const RobotPlan& plan) {
  return FindSimulation(plan.source) == nullptr ? "client_agent" : "simulated_agent";
}

absl::Status ProcessRun::StartAgent(const RobotPlan& plan, bool stays) {
  RunningAgent agent;
  agent.plan = plan;
  {
    ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(plan.source));
    agent.frames = FramesOf(plan.source, reader->frame_count()).size();
  }
  ASSIGN_OR_RETURN(agent.statistics_path, MakeFreshPath(plan.name + ".json"));
  ASSIGN_OR_RETURN(agent.held_map_path, MakeFreshPath(plan.name + ".map"));
  agent.told_stem = absl::StrCat(options_.log_folder, "/", plan.name, ".told");
  std::vector<std::string> arguments = {"--source",   FormatSourceSpec(plan.source),
                                        "--server",   store_address_,
                                        "--mission",  options_.mission,
                                        "--agent",    plan.name,
                                        "--pace",     options_.pace,
                                        "--stats",    agent.statistics_path,
                                        "--held-map", agent.held_map_path,
                                        "--told",     agent.told_stem};
  if (options_.seed.has_value()) {
    arguments.insert(arguments.end(), {"--seed", absl::StrCat(*options_.seed)});
  }
  // The store is this run's own, on loopback, or one that the flags say how to reach.
  SecurityOptions own;
  own.insecure = true;
  AppendFlags(options_.server.empty() ? own : options_.security, arguments);
  if (options_.strict) arguments.push_back("--strict");
  if (options_.alone) arguments.insert(arguments.end(), {"--share", "none"});
  if (stays) {
    arguments.insert(arguments.end(), {"--stay", "--listen", "127.0.0.1:0", "--listen-insecure"});
  }
  ASSIGN_OR_RETURN(const std::vector<std::string> command,
                   MakeCommand(AgentProgram(plan), std::move(arguments), true));
  ASSIGN_OR_RETURN(agent.process,
                   ChildProcess::Start(plan.name, command,
                                       absl::StrCat(options_.log_folder, "/", plan.name, ".log")));
  if (stays) {
    const absl::StatusOr<std::string> address = agent.process->WaitForAddress(kStartTimeout);
    agent.failure.Update(address.status());
    if (address.ok()) {
      agent.address = *address;
      agent.stub =
          v1::Agent::NewStub(std::shared_ptr<grpc::ChannelInterface>(MakeChannel(*address)));
    }
  }
  agents_.push_back(std::move(agent));
  return absl::OkStatus();
}

void ProcessRun::WaitForAgents() {
  if (store_ == nullptr) {
    store_ = std::make_unique<StoreReader>(MakeChannel(store_address_), options_.mission);
  }
  for (RunningAgent& agent : agents_) {
    while (!agent.process->WaitUntilFinished(kProgressInterval)) ShowProgress("mapping");
    if (agent.process->end().has_value()) agent.failure.Update(agent.process->EndStatus());
  }
}

// Returns how many shared updates came to it; 0 where it does not answer.
uint64_t AskSharedUpdates(v1::Agent::Stub& stub) {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + absl::Seconds(10)));
  v1::AgentStatus status;
  return stub.GetStatus(&context, {}, &status).ok() ? status.shared_updates() : 0;
}

bool ProcessRun::KnowsAll(const RunningAgent& agent,
                          const std::map<std::string, v1::MissionAgent>& at_store) const {
  if (agent.stub == nullptr || agent.process->end().has_value()) return true;
  const auto it = at_store.find(agent.plan.name);
  // One that brought nothing, or has no session any more, is told nothing.
  if (it == at_store.end() || !it->second.connected()) return true;
  return it->second.up_to_date() && AskSharedUpdates(*agent.stub) == it->second.shared_updates();
}

absl::Status ProcessRun::WaitUntilShared() {
  const absl::Time deadline = absl::Now() + kSharingTimeout;
  while (true) {
    ASSIGN_OR_RETURN(const auto at_store, store_->ListAgents());
    const auto waits = std::ranges::find_if_not(
        agents_, [&](const RunningAgent& agent) { return KnowsAll(agent, at_store); });
    if (waits == agents_.end()) return absl::OkStatus();
    if (absl::Now() > deadline) {
      LOG(WARNING) << waits->plan.name << " was not told all of the map after "
                   << absl::FormatDuration(kSharingTimeout);
      return absl::OkStatus();
    }
    absl::SleepFor(kAskAgain);
  }
}

void ProcessRun::StopAgents() {
  for (RunningAgent& agent : agents_) {
    agent.process->Stop(kAgentStopGrace);
    agent.failure.Update(agent.process->EndStatus());
  }
}

// Waits until the store has fused; a store knows no mission if no robot brought anything.
absl::Status ProcessRun::WaitUntilFused() {
  const absl::Status fused = store_->WaitUntilFused(options_.fusion_timeout);
  return absl::IsNotFound(fused) ? absl::OkStatus() : fused;
}

void ProcessRun::ShowProgress(const std::string& stage) {
  if (on_progress_ == nullptr) return;
  Progress progress;
  progress.stage = stage;
  const auto frames = store_->CountReportedFrames();
  for (const RunningAgent& agent : agents_) {
    const auto found = frames.ok() ? frames->find(agent.plan.name) : decltype(frames->end()){};
    const uint64_t done = frames.ok() && found != frames->end() ? found->second : 0;
    progress.robots.push_back({agent.plan.name, absl::StrCat(done, "/", agent.frames)});
  }
  on_progress_(progress);
}

absl::StatusOr<RobotReport> ReadStatistics(const RunningAgent& agent) {
  std::ifstream file(agent.statistics_path);
  const auto json = nlohmann::ordered_json::parse(file, nullptr, false);
  if (!json.is_discarded()) return RobotReportFromJson(json);
  return absl::DataLossError(
      absl::StrCat(agent.plan.name, " left no statistics in ", agent.statistics_path));
}

// Returns a report even if the robot failed, with what it left and why it failed.
RobotReport ReadRobotReport(RunningAgent& agent) {
  absl::StatusOr<RobotReport> read = ReadStatistics(agent);
  agent.failure.Update(read.status());
  RobotReport report = read.ok() ? *std::move(read) : RobotReport();
  if (!agent.failure.ok()) {
    report.warnings.push_back({"", "robot-failed", std::string(agent.failure.message())});
  }
  report.name = agent.plan.name;
  report.source = FormatSourceSpec(agent.plan.source);
  const std::optional<ProcessEnd> end = agent.process->end();
  report.peak_rss_mb = end->peak_rss_mb;
  report.cpu_s = end->cpu_s;
  return report;
}

// Returns nullopt if the robot left none: why it failed is known by then.
std::optional<NearMap> ReadRobotHeldMap(const RunningAgent& agent) {
  absl::StatusOr<std::optional<NearMap>> held = ReadHeldMap(agent.held_map_path);
  if (held.ok()) return *std::move(held);
  LOG(WARNING) << agent.plan.name << " has no picture of its map: " << held.status();
  return std::nullopt;
}

// Returns none if the robot left none: why it failed is known by then.
ToldPaths ReadRobotToldPaths(const RunningAgent& agent) {
  absl::StatusOr<ToldPaths> told = ReadToldPaths(agent.told_stem);
  if (told.ok()) return *std::move(told);
  LOG(WARNING) << agent.plan.name << " left no poses as they were told: " << told.status();
  return {};
}

void ProcessRun::StopServers(MissionOutcome& outcome) {
  // The store is stopped first, so that it does not miss its worker.
  for (auto server = servers_.rbegin(); server != servers_.rend(); ++server) {
    const ProcessEnd end = (*server)->Stop(kStopGrace);
    outcome.report.servers[(*server)->name()] = {end.peak_rss_mb, end.cpu_s};
  }
}

absl::StatusOr<MissionOutcome> ProcessRun::Run() {
  RETURN_IF_ERROR(StartServers());
  // Agents that play one after the other are not there yet.
  if (options_.view && options_.sequential) RETURN_IF_ERROR(StartViewer());
  for (const RobotPlan& plan : options_.robots) {
    const bool is_last = agents_.size() + 1 == options_.robots.size();
    RETURN_IF_ERROR(StartAgent(plan, is_last || !options_.sequential));
    if (options_.sequential) WaitForAgents();
  }
  if (options_.view && !options_.sequential) RETURN_IF_ERROR(StartViewer());
  WaitForAgents();
  ShowProgress("fusing");
  RETURN_IF_ERROR(WaitUntilFused());
  RETURN_IF_ERROR(WaitUntilShared());
  StopAgents();
  MissionOutcome outcome;
  RETURN_IF_ERROR(ReadOutcome(*store_, options_, outcome));
  for (size_t i = 0; i < agents_.size(); ++i) {
    RunningAgent& agent = agents_[i];
    outcome.paths[i].told = ReadRobotToldPaths(agent);
    outcome.report.robots.push_back(ReadRobotReport(agent));
    outcome.held.push_back(ReadRobotHeldMap(agent));
    if (agent.failure.ok()) continue;
    outcome.failures.push_back(absl::StrCat(agent.plan.name, ": ", agent.failure.message()));
  }
  StopServers(outcome);
  return outcome;
}

}  // namespace

absl::StatusOr<MissionOutcome> RunProcesses(const MissionRunOptions& options,
                                            const ProgressListener& on_progress) {
  return ProcessRun(options, on_progress).Run();
}

}  // namespace corbslam::services

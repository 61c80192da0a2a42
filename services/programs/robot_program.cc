#include "services/programs/robot_program.h"

#include <glog/logging.h>

#include <cstdio>
#include <future>
#include <memory>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "client_agent/agent/agent.h"
#include "client_agent/live/live_sources.h"
#include "client_agent/source/bag/bag_source.h"
#include "services/agent_service/agent_service.h"
#include "services/client/remote/place_asker.h"
#include "services/client/remote/remote_uplink.h"
#include "services/command_line/secrets.h"
#include "services/convert/resource_names.h"
#include "services/observe/logging/log_fields.h"
#include "services/programs/live_settings.h"
#include "services/programs/memory_needs.h"
#include "services/programs/program.h"
#include "services/programs/robot/agent_run.h"
#include "services/programs/robot/agent_trajectories.h"
#include "services/programs/robot/held_map_file.h"
#include "services/programs/robot/map_wait.h"
#include "services/programs/robot/robot_report.h"
#include "services/programs/robot/robot_source.h"
#include "services/programs/robot/source_json.h"
#include "services/programs/robot/told_poses.h"
#include "services/programs/robot_flag_checks.h"
#include "services/programs/robot_flags.h"
#include "services/programs/robot_observers.h"
#include "services/programs/settings_flags.h"
#include "services/programs/spool_flags.h"
#include "services/programs/start_lines.h"
#include "services/server/self_watch.h"
#include "services/server/server.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::services {

using client_agent::ActivityWatch;
using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::AgentOrders;
using client_agent::FrameStream;
using client_agent::RegisterBagSource;
using client_agent::RegisterLiveSources;
using client_agent::Spool;
using client_agent::TrackingResult;

namespace {

// Streams end within it, where their readers read.
constexpr absl::Duration kGoodbye = absl::Seconds(1);

AgentOptions MakeAgentOptions(const RobotFlags& flags, const UploadChoice& upload,
                              const std::shared_ptr<const ActivityWatch>& activity) {
  AgentOptions options;
  options.mission = flags.mission;
  options.name = flags.agent;
  // Ids of local maps are drawn from the seed, which is another one each time unless the flag sets
  // it.
  options.seed = flags.seed != 0
                     ? flags.seed
                     : (uint64_t{std::random_device()()} << 32) | std::random_device()();
  options.deterministic = flags.pace == Pace::kStep;
  options.solver_threads = flags.solver_threads;
  options.max_outbox_bytes = OutboxBytesOf(flags);
  options.upload_features = upload.features;
  options.picture_width_px = upload.picture_width_px;
  options.uplink_bytes_per_second = BytesPerSecond(flags.uplink_kbps);
  options.downlink_bytes_per_second = BytesPerSecond(flags.downlink_kbps);
  options.share = ScopeOf(flags, IsBounded(flags));
  options.localise_only = flags.localise_only;
  ApplySpoolFlags(flags.spool, options);
  options.max_map_bytes = MaxMapBytes(flags.memory_budget_bytes, MemoryNeedsOf(flags),
                                      /*has_server=*/!flags.server.empty());
  // The trajectory is asked for at the end, or by other programs at any time.
  options.keep_trajectory = !flags.trajectory.empty() || !flags.listen.empty();
  options.events = std::make_shared<client_agent::AgentEvents>();
  options.activity = activity;
  options.sensor.orb.features = FeaturesOf(flags);
  return options;
}

RobotReport MakeReport(const RobotFlags& flags, const Agent& agent, const RobotSource& source,
                       const PlayedFrames& played, const Uplink* uplink,
                       const absl::Status& session) {
  RobotReport report = MakeRobotReport(agent);
  report.name = flags.agent;
  report.source = flags.source;
  report.source_description = ToJson(source.description);
  const RobotTask task = {.localise_only = flags.localise_only,
                          .resume = flags.spool.resume,
                          .mission = flags.mission,
                          .shares_nearby = flags.share == ShareMode::kNearby,
                          .session = session};
  AddRun(*source.stream, played,
         CollectWarnings(source.warnings, agent, *source.stream, played, task), report);
  if (uplink != nullptr) {
    report.bytes_up = uplink->bytes_up();
    report.bytes_down = uplink->bytes_down();
  }
  return report;
}

LogFields WhoOf(const RobotFlags& flags) {
  return {.mission = flags.server.empty() ? "" : flags.mission, .agent = flags.agent};
}

std::string DescribeStart(const RobotFlags& flags) {
  std::string line = absl::StrCat("plays ", HideSecrets(flags.source), "; ");
  if (flags.server.empty()) {
    absl::StrAppend(&line, "alone, without a map store");
  } else {
    absl::StrAppend(&line, "map store ", flags.server, " ", DescribeCalling(flags.security));
  }
  if (!flags.spool.folder.empty()) absl::StrAppend(&line, "; spool in ", flags.spool.folder);
  return line;
}

absl::Status WriteResults(const RobotFlags& flags, const Agent& agent, const ToldPoses& told,
                          const SensorCalibration& calibration, const RobotReport& report) {
  if (!flags.trajectory.empty()) {
    RETURN_IF_ERROR(WriteAgentTrajectories(agent, calibration, flags.poses_of, flags.trajectory));
  }
  if (!flags.held_map.empty()) RETURN_IF_ERROR(WriteHeldMap(GetHeldMap(agent), flags.held_map));
  if (!flags.told.empty()) RETURN_IF_ERROR(WriteToldPaths(told.paths(), flags.told));
  LOG(INFO) << WhoOf(flags) << DescribeEnd(report);
  if (flags.stats.empty()) return absl::OkStatus();
  return WriteAtomically(flags.stats, ToJson(report).dump(2) + "\n");
}

std::unique_ptr<LiveSettings> MakeLiveSettings(const RobotFlags& flags,
                                               const std::shared_ptr<AgentOrders>& orders,
                                               const std::shared_ptr<FrameRateLimit>& rate) {
  const auto limits = [flags](const SettableFlags& begun, const SettableFlags& set) {
    const RobotFlags now = With(set, flags);
    // Its features and its outbox stay as they are.
    const MemoryNeeds needs = MemoryNeedsOf(With(begun, flags));
    return client_agent::ChangedLimits{.uplink_bytes_per_second = BytesPerSecond(now.uplink_kbps),
                                       .max_map_bytes = MaxMapBytes(now.memory_budget_bytes, needs),
                                       .share = ScopeOf(now, IsBounded(now))};
  };
  return std::make_unique<LiveSettings>(LiveSettingsOptions{
      .files = flags.settings,
      .mission = flags.mission,
      .agent = flags.agent,
      .flags = flags,
      .given = flags.given,
      .orders = orders,
      .rate = rate,
      .check = [flags](const SettableFlags& set) { return CheckSettable(With(set, flags)); },
      .limits = limits});
}

// Returns null without a route. `settings` is not owned and must outlive the uplink.
std::unique_ptr<Uplink> MakeUplink(const RobotFlags& flags, std::shared_ptr<StoreRoute> route,
                                   LiveSettings& settings) {
  if (route == nullptr) return nullptr;
  RemoteUplinkOptions options;
  options.on_settings = [&settings](const auto& list) { settings.OnSettings(list); };
  options.take_over = flags.take_over;
  return MakeRemoteUplink(std::move(route), options);
}

// Returns how other programs on the robot reach it.
absl::StatusOr<ServerSecurity> MakeListenSecurity(const RobotFlags& flags) {
  if (flags.listen.empty()) return ServerSecurity{};
  return MakeServerSecurity(Bearing(ListenSecurityOf(flags), Files::kMayCome), flags.mission,
                            flags.agent);
}

// Returns an error if the run mapped nothing: that is no success.
absl::Status CheckTracked(const RobotReport& report) {
  for (const ReportWarning& warning : report.warnings) {
    if (warning.code == "nothing-tracked") return absl::FailedPreconditionError(warning.text);
  }
  return absl::OkStatus();
}

// Returns the status of a robot that has begun: what it met then is not wrong usage
// (docs/exit_codes.md).
absl::Status AsFailure(const absl::Status& status) {
  if (!absl::IsInvalidArgument(status)) return status;
  return absl::FailedPreconditionError(
      absl::StrCat("INVALID_ARGUMENT while it ran: ", status.message()));
}

// What is around a robot's agent. The agent closes the uplink, which must outlive it and tells
// the settings what the store sets.
struct Surroundings {
  std::shared_ptr<AgentOrders> orders = std::make_shared<AgentOrders>();
  std::shared_ptr<FrameRateLimit> rate = std::make_shared<FrameRateLimit>();
  std::shared_ptr<ActivityWatch> activity = std::make_shared<ActivityWatch>();
  std::shared_ptr<StoreRoute> route;  // Null without --server, and so is the uplink.
  std::unique_ptr<LiveSettings> settings;
  std::unique_ptr<Uplink> uplink;
  std::shared_ptr<RobotObservers> observers;
  RobotCompanion* companion = nullptr;
};

// Hours of mapping must not be lost because of a folder that isn't there.
absl::Status CheckBefore(const RobotFlags& flags) {
  RETURN_IF_ERROR(CheckNameSegment("--mission", flags.mission));
  RETURN_IF_ERROR(CheckNameSegment("--agent", flags.agent));
  for (const absl::Status& place : CheckPlaces(flags)) RETURN_IF_ERROR(place);
  return absl::OkStatus();
}

// Returns the flags with what is known of the source.
RobotFlags WithSource(const SensorCalibration& calibration, RobotFlags flags) {
  const Camera camera = FirstCameraOf(calibration).camera;
  flags.has_depth = KindOf(calibration) == SensorKind::kRgbd;
  flags.width_px = camera.width_px;
  flags.height_px = camera.height_px;
  return flags;
}

// Says to who gives orders which masks fit.
void TellPictures(const RobotFlags& flags, const RobotSource& source, AgentOrders& orders) {
  Camera camera;
  camera.width_px = flags.width_px;
  camera.height_px = flags.height_px;
  orders.SetCamera(camera);
  if (const auto& size_px = source.description.unscaled_px; size_px.has_value()) {
    orders.SetRecordedSize(size_px->first, size_px->second);
  }
}

// Surrounds a robot whose source is open, and returns the flags that it runs with: with what its
// map store sets, as far as it can run with that.
absl::StatusOr<RobotFlags> Surround(const RobotFlags& given, const RobotSource& source,
                                    const absl::StatusOr<v1::RobotSettingsList>& told,
                                    Surroundings& around) {
  TellPictures(given, source, *around.orders);
  around.settings = MakeLiveSettings(given, around.orders, around.rate);
  RobotFlags flags = With(around.settings->Begin(told), given);
  // By now it is known how large the pictures are.
  RETURN_IF_ERROR(CheckSettable(flags));
  around.uplink = MakeUplink(flags, around.route, *around.settings);
  around.observers = std::make_unique<RobotObservers>(flags.observe, flags.mission, flags.agent);
  around.observers->WatchActivity(around.activity);
  if (around.uplink != nullptr) {
    around.observers->LogSessions({flags.server, kMapStoreService, flags.security},
                                  flags.localise_only);
  }
  return flags;
}

void LogMemoryBudget(const RobotFlags& flags, uint64_t max_map_bytes) {
  if (max_map_bytes == 0) return;
  LOG(INFO) << "memory budget: " << (flags.memory_budget_bytes >> 20) << " MiB, of which "
            << (max_map_bytes >> 20) << " MiB are for the local map in use"
            << (flags.share.has_value() || flags.server.empty()
                    ? ""
                    : "; --share is nearby, because of it");
}

absl::StatusOr<AgentOptions> SurroundedOptions(const RobotFlags& flags,
                                               const Surroundings& around) {
  ASSIGN_OR_RETURN(const UploadChoice upload, ParseUpload(flags));
  AgentOptions options = MakeAgentOptions(flags, upload, around.activity);
  const bool has_companion = around.companion != nullptr;
  if (around.uplink != nullptr || !flags.listen.empty() || has_companion) {
    options.orders = around.orders;
  }
  if (around.uplink != nullptr) around.observers->LogEvents(options.events);
  if (around.route != nullptr) {
    options.ask_place = MakePlaceAsker(around.route, flags.mission);
  }
  LogMemoryBudget(flags, options.max_map_bytes);
  return options;
}

AgentServiceOptions ServiceOptions(const RobotFlags& flags, const Surroundings& around,
                                   const RecordedCamera& recorded, const AgentOptions& options,
                                   v1::AgentClock clock) {
  return {.mission = around.uplink != nullptr ? flags.mission : "",
          .agent = flags.agent,
          .recorded_camera = recorded,
          .session = around.observers->OfSessions(),
          .orders = options.orders,
          .events = options.events,
          .activity = around.activity,
          .localise_only = flags.localise_only,
          .clock = clock};
}

// A camera's frames are stamped by the machine's monotonic clock (docs/live.md), unless a companion
// knows better.
v1::AgentClock ClockOf(const FrameStream& stream, const RobotCompanion* companion) {
  if (companion != nullptr) return companion->clock();
  return stream.camera_counts().has_value() ? v1::AGENT_CLOCK_MONOTONIC : v1::AGENT_CLOCK_RECORDED;
}

// Serves other programs on the robot; returns null without --listen.
absl::StatusOr<std::unique_ptr<Server>> Serve(const RobotFlags& flags, ServerSecurity security,
                                              AgentService& service) {
  if (flags.listen.empty()) return nullptr;
  ASSIGN_OR_RETURN(std::unique_ptr<Server> server,
                   Server::Start(flags.listen, {&service}, security.server));
  LOG(INFO) << WhoOf(flags) << "serves " << server->address() << " "
            << DescribeServing(ListenSecurityOf(flags));
  AnnounceAddress(server->address());
  return server;
}

absl::Status BeginCompanion(const RobotFlags& flags, const Surroundings& around, const Agent& agent,
                            const RecordedCamera& recorded) {
  if (around.companion == nullptr) return absl::OkStatus();
  return around.companion->Begin({&agent, flags.agent, recorded, around.orders,
                                  around.uplink != nullptr, around.observers->OfSessions()});
}

// Drives the robot from its source's first frame to its last, and writes what is asked for.
absl::Status Drive(const RobotFlags& flags, const Surroundings& around, const RobotSource& source,
                   const std::shared_ptr<const Vocabulary>& vocabulary,
                   std::unique_ptr<Spool> spool, const absl::Notification& stop) {
  const SensorCalibration& calibration = source.stream->calibration();
  Uplink* const uplink = around.uplink.get();
  RobotObservers& observers = *around.observers;
  ASSIGN_OR_RETURN(const RecordedCamera recorded, RecordedCameraOf(calibration));
  ASSIGN_OR_RETURN(ServerSecurity security, MakeListenSecurity(flags));
  ASSIGN_OR_RETURN(const AgentOptions options, SurroundedOptions(flags, around));
  ASSIGN_OR_RETURN(const auto recorder,
                   StartRecording(flags.record,
                                  {options, flags.source, flags.pace, uplink != nullptr,
                                   vocabulary->fingerprint()},
                                  *source.stream));
  ASSIGN_OR_RETURN(const auto agent, Agent::Create(options, calibration, vocabulary,
                                                   observers.Watch(uplink), std::move(spool)));
  around.settings->GiveMask();
  Agent* const watched = observers.Watch(agent.get());
  const auto recording =
      recorder != nullptr ? recorder->Watch(watched, options.orders.get()) : nullptr;
  AgentService service(
      agent.get(), uplink,
      ServiceOptions(flags, around, recorded, options, ClockOf(*source.stream, around.companion)));
  ASSIGN_OR_RETURN(const auto metrics, observers.Serve(agent.get(), uplink,
                                                       {{"spool", flags.spool.folder},
                                                        {"recordings", flags.record.folder}}));
  security.server.rpc_observer = observers.OfCalls();
  ASSIGN_OR_RETURN(const auto server, Serve(flags, security, service));
  if (flags.localise_only) WaitForMap(*agent, flags.mission, stop);
  RETURN_IF_ERROR(BeginCompanion(flags, around, *agent, recorded));
  ToldPoses told(recorded, /*keeps_paths=*/!flags.told.empty());
  PlayedFrames frames;
  const absl::Status played = PlayStream(
      *source.stream, recording != nullptr ? *recording : *watched, flags.pace, stop, frames,
      [&](const TrackingResult& result, const FrameMoment& moment) {
        observers.SetDropped(moment.dropped);
        around.activity->NoteFrame(result, moment.came, moment.dropped);
        if (recorder != nullptr) recorder->OnResult(result, moment.dropped);
        service.OnFrame(result, moment.dropped, moment.came);
        told.Add(result);
        if (around.companion != nullptr) around.companion->OnFrame(result, moment);
      },
      around.rate.get());
  around.activity->NoteEnd();
  service.OnEnd();
  if (around.companion != nullptr) around.companion->OnEnd();
  // What became of the recording is in the log: it is no failure of the robot.
  if (recorder != nullptr) recorder->Finish().IgnoreError();
  const auto of_sessions = observers.OfSessions();
  const absl::Status session = of_sessions == nullptr ? absl::OkStatus() : of_sessions();
  // A frame that can't be read ends the drive, but what was mapped until then stays.
  const absl::Status finished = agent->Finish(absl::Seconds(flags.finish_s));
  if (flags.stay && played.ok() && finished.ok()) {
    AnnounceFinished();
    stop.WaitForNotification();
  }
  // Whoever watches hears the end.
  if (server != nullptr) server->Shutdown(kGoodbye);
  RobotReport report = MakeReport(flags, *agent, source, frames, uplink, session);
  report.settings = around.settings->Report();
  AddJumps(told.jumps(), report);
  RETURN_IF_ERROR(WriteResults(flags, *agent, told, calibration, report));
  RETURN_IF_ERROR(AsFailure(played));
  RETURN_IF_ERROR(CheckTracked(report));
  return AsFailure(finished);
}

absl::Status Run(const RobotFlags& given, RobotCompanion* companion) {
  RETURN_IF_ERROR(CheckBefore(given));
  Surroundings around;
  around.companion = companion;
  ASSIGN_OR_RETURN(around.route, MakeStoreRoute(given, Files::kMayCome));
  std::future<absl::StatusOr<v1::RobotSettingsList>> told =
      AskForSettings(around.route, given.settings, given.mission, given.agent);
  ASSIGN_OR_RETURN(std::unique_ptr<Spool> spool,
                   OpenSpool(given.spool, AgentName(given.mission, given.agent)));
  RETURN_IF_ERROR(CheckListenSecurity(given, Files::kMayCome));
  LOG(INFO) << WhoOf(given) << DescribeStart(given);
  // A robot may wait for its camera for long, and is well meanwhile.
  const SelfWatch watch({});
  const StopWatcher stop;
  ASSIGN_OR_RETURN(const auto vocabulary, Vocabulary::Load(given.vocabulary));
  if (companion != nullptr) RETURN_IF_ERROR(companion->Prepare());
  const absl::StatusOr<RobotSource> source = OpenFlaggedSource(given, stop.stopped());
  // It was stopped while it waited for who drives its camera.
  if (absl::IsCancelled(source.status())) return absl::OkStatus();
  RETURN_IF_ERROR(source.status());
  LogSource(*source);
  const SensorCalibration& calibration = source->stream->calibration();
  RETURN_IF_ERROR(CheckPosesOf(calibration, given.poses_of));
  ASSIGN_OR_RETURN(const RobotFlags flags,
                   Surround(WithSource(calibration, given), *source, told.get(), around));
  return Drive(flags, around, *source, vocabulary, std::move(spool), stop.stopped());
}

}  // namespace

int RunRobot(const std::string& program, int argc, char** argv, RobotCompanion* companion) {
  BlockStopSignals();
  RegisterLiveSources();
  RegisterBagSource();
  RobotFlags flags;
  CLI::App app("One robot of a shared exploration", program);
  AddRobotFlags(app, flags);
  const auto run = [&] {
    flags.given = GivenFlags(app);
    return Run(flags, companion);
  };
  return RunProgram(app, argc, argv, {run, [&] { return CheckRobotFlags(flags); }});
}

}  // namespace corbslam::services

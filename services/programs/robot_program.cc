#include "services/programs/robot_program.h"

#include <glog/logging.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/strip.h"
#include "client_agent/agent/agent.h"
#include "client_agent/live/live_sources.h"
#include "client_agent/source/source_kinds.h"
#include "services/agent_service/agent_service.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/place_asker.h"
#include "services/client/remote/remote_uplink.h"
#include "services/command_line/help_formatter.h"
#include "services/command_line/secrets.h"
#include "services/convert/errors.h"
#include "services/convert/resource_names.h"
#include "services/observe/logging/log_fields.h"
#include "services/programs/checks.h"
#include "services/programs/default_vocabulary.h"
#include "services/programs/link_flags.h"
#include "services/programs/live_settings.h"
#include "services/programs/memory_flags.h"
#include "services/programs/observe_flags.h"
#include "services/programs/program.h"
#include "services/programs/record_flags.h"
#include "services/programs/robot/agent_run.h"
#include "services/programs/robot/agent_trajectories.h"
#include "services/programs/robot/held_map_file.h"
#include "services/programs/robot/robot_report.h"
#include "services/programs/robot/robot_source.h"
#include "services/programs/robot/source_json.h"
#include "services/programs/robot_observers.h"
#include "services/programs/settings_flags.h"
#include "services/programs/share_flags.h"
#include "services/programs/spool_flags.h"
#include "services/programs/start_lines.h"
#include "services/security/flags.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::AgentOrders;
using client_agent::ApplyOptions;
using client_agent::FeatureSelection;
using client_agent::ListSources;
using client_agent::ParseFeatureSelection;
using client_agent::ParseSourceSpec;
using client_agent::RegisterLiveSources;
using client_agent::SourceSpec;
using client_agent::SourceUsage;
using client_agent::Spool;
using client_agent::TrackingResult;
using client_agent::UseRig;

namespace {

struct Flags : SettableFlags {
  std::string source;
  std::string rig;
  std::string frames;
  std::string server;
  std::string mission = "default";
  std::string agent = "agent";
  Pace pace = Pace::kMax;
  std::string listen;
  std::string stats;
  std::string held_map;
  std::string trajectory;
  PosesOf poses_of = PosesOf::kRecordedCamera;
  std::string vocabulary = DefaultVocabularyPath();
  uint64_t seed = 0;
  int solver_threads = 1;
  double finish_s = 120;
  SpoolFlags spool;
  uint64_t outbox_mb = 64;
  SettingsFlags settings;
  std::set<std::string> given;  // Of SettableFlags.
  RecordFlags record;
  bool stay = false;
  bool strict = false;
  bool take_over = false;
  bool localise_only = false;
  SecurityOptions security;
  ObserveFlags observe;
  bool listen_insecure = false;
};

absl::StatusOr<SourceSpec> FlaggedSource(const Flags& flags) {
  ASSIGN_OR_RETURN(SourceSpec spec, ParseSourceSpec(flags.source));
  if (!flags.rig.empty()) RETURN_IF_ERROR(UseRig(flags.rig, spec));
  if (!flags.frames.empty()) RETURN_IF_ERROR(ApplyOptions("frames=" + flags.frames, spec));
  return spec;
}

absl::StatusOr<RobotSource> OpenFlaggedSource(const Flags& flags, const absl::Notification& stop) {
  ASSIGN_OR_RETURN(const SourceSpec spec, FlaggedSource(flags));
  return OpenRobotSource(spec, flags.strict, stop);
}

absl::Status CheckFlaggedSource(const Flags& flags) {
  ASSIGN_OR_RETURN(const SourceSpec spec, FlaggedSource(flags));
  return CheckRobotSource(spec, flags.strict);
}

absl::Status CheckPace(const Flags& flags) {
  if (flags.pace != Pace::kStep || flags.server.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--pace step is of a robot alone: with --server what comes depends on the network; "
      "corbslam run --pace step plays several robots and a store in lockstep");
}

absl::Status CheckLocaliseOnly(const Flags& flags) {
  if (!flags.localise_only) return absl::OkStatus();
  if (flags.server.empty()) {
    return absl::InvalidArgumentError("--localise-only needs --server, whose map it localises in");
  }
  const ShareMode mode = flags.share.mode.value_or(ShareMode::kEverything);
  if (mode == ShareMode::kNone || mode == ShareMode::kCorrections) {
    return absl::InvalidArgumentError(
        "--localise-only needs others' keyframes: --share nearby or everything");
  }
  if (!flags.spool.folder.empty()) {
    return absl::InvalidArgumentError(
        "--spool (--spool-dir) keeps what a robot maps, and with --localise-only it maps nothing");
  }
  return absl::OkStatus();
}

absl::StatusOr<FeatureSelection> ParseUpload(const Flags& flags) {
  absl::string_view text = flags.upload;
  if (!absl::ConsumePrefix(&text, "features=")) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--upload is ", flags.upload, ", must be features=all, features=mapped or features=N"));
  }
  const absl::StatusOr<FeatureSelection> selection = ParseFeatureSelection(text);
  if (selection.ok()) return selection;
  return Locate(selection.status(), "--upload");
}

ShareFlags ShareOf(const Flags& flags) {
  const bool is_bounded = flags.memory.budget_bytes > 0 && !flags.server.empty();
  return is_bounded ? WithBoundedMemory(flags.share) : flags.share;
}

AgentOptions MakeAgentOptions(const Flags& flags, const FeatureSelection& upload,
                              const SensorCalibration& calibration) {
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
  options.max_outbox_bytes = flags.outbox_mb << 20;
  options.upload_features = upload;
  options.uplink_bytes_per_second = BytesPerSecond(flags.link.uplink_kbps);
  options.downlink_bytes_per_second = BytesPerSecond(flags.link.downlink_kbps);
  options.share = ScopeOf(ShareOf(flags));
  options.localise_only = flags.localise_only;
  ApplySpoolFlags(flags.spool, options);
  options.max_map_bytes = MaxMapBytes(flags.memory, options.max_outbox_bytes,
                                      /*has_server=*/!flags.server.empty());
  // The trajectory is asked for at the end, or by other programs at any time.
  options.keep_trajectory = !flags.trajectory.empty() || !flags.listen.empty();
  options.events = std::make_shared<client_agent::AgentEvents>();
  const bool stereo = std::holds_alternative<StereoCalibration>(calibration);
  options.sensor.orb.features = flags.features != 0 ? flags.features : stereo ? 2000 : 1000;
  return options;
}

absl::Status WriteText(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) return absl::UnavailableError(absl::StrCat("can't write ", path));
  return absl::OkStatus();
}

RobotReport MakeReport(const Flags& flags, const Agent& agent, const RobotSource& source,
                       const PlayedFrames& played, const Uplink* uplink) {
  RobotReport report = MakeRobotReport(agent);
  report.name = flags.agent;
  report.source = flags.source;
  report.source_description = ToJson(source.description);
  AddRun(*source.stream, played, CollectWarnings(source.warnings, agent, *source.stream, played),
         report);
  if (uplink != nullptr) {
    report.bytes_up = uplink->bytes_up();
    report.bytes_down = uplink->bytes_down();
  }
  return report;
}

LogFields WhoOf(const Flags& flags) {
  return {.mission = flags.server.empty() ? "" : flags.mission, .agent = flags.agent};
}

std::string DescribeStart(const Flags& flags) {
  std::string line = absl::StrCat("plays ", HideSecrets(flags.source), "; ");
  if (flags.server.empty()) {
    absl::StrAppend(&line, "alone, without a map store");
  } else {
    absl::StrAppend(&line, "map store ", flags.server, " ", DescribeCalling(flags.security));
  }
  if (!flags.spool.folder.empty()) absl::StrAppend(&line, "; spool in ", flags.spool.folder);
  return line;
}

absl::Status WriteResults(const Flags& flags, const Agent& agent,
                          const SensorCalibration& calibration, const RobotReport& report) {
  if (!flags.trajectory.empty()) {
    RETURN_IF_ERROR(WriteAgentTrajectories(agent, calibration, flags.poses_of, flags.trajectory));
  }
  if (!flags.held_map.empty()) RETURN_IF_ERROR(WriteHeldMap(GetHeldMap(agent), flags.held_map));
  LOG(INFO) << WhoOf(flags) << DescribeEnd(report);
  if (flags.stats.empty()) return absl::OkStatus();
  return WriteText(flags.stats, ToJson(report).dump(2) + "\n");
}

// Returns null without --server.
absl::StatusOr<std::shared_ptr<grpc::Channel>> MakeStoreChannel(const Flags& flags) {
  if (flags.server.empty()) return nullptr;
  ASSIGN_OR_RETURN(const auto credentials, MakeChannelCredentials(flags.security));
  return MakeChannel(flags.server, credentials);
}

// Checks what the map store may set.
absl::Status CheckSettable(const Flags& flags) {
  const bool has_server = !flags.server.empty();
  RETURN_IF_ERROR(CheckMemoryFlags(flags.memory, flags.share, flags.outbox_mb << 20,
                                   has_server || !flags.spool.folder.empty()));
  RETURN_IF_ERROR(CheckShareFlags(ShareOf(flags), has_server));
  RETURN_IF_ERROR(CheckLocaliseOnly(flags));
  return ParseUpload(flags).status();
}

Flags With(const SettableFlags& set, Flags flags) {
  static_cast<SettableFlags&>(flags) = set;
  return flags;
}

absl::StatusOr<std::unique_ptr<LiveSettings>> MakeLiveSettings(
    const Flags& flags, const std::shared_ptr<AgentOrders>& orders,
    const std::shared_ptr<FrameRateLimit>& rate) {
  const auto limits = [flags](const SettableFlags& set) {
    const Flags now = With(set, flags);
    return client_agent::ChangedLimits{
        .uplink_bytes_per_second = BytesPerSecond(now.link.uplink_kbps),
        .max_map_bytes = MaxMapBytes(now.memory, now.outbox_mb << 20),
        .share = ScopeOf(ShareOf(now))};
  };
  return LiveSettings::Make(
      {.files = flags.settings,
       .mission = flags.mission,
       .agent = flags.agent,
       .flags = flags,
       .given = flags.given,
       .orders = orders,
       .rate = rate,
       .check = [flags](const SettableFlags& set) { return CheckSettable(With(set, flags)); },
       .limits = limits});
}

// Returns null without a channel. `settings` is not owned and must outlive the uplink.
std::unique_ptr<Uplink> MakeUplink(const Flags& flags, std::shared_ptr<grpc::Channel> channel,
                                   LiveSettings& settings) {
  if (channel == nullptr) return nullptr;
  RemoteUplinkOptions options;
  options.on_settings = [&settings](const auto& list) { settings.OnSettings(list); };
  options.take_over = flags.take_over;
  return MakeRemoteUplink(std::move(channel), options);
}

SecurityOptions ListenSecurityOf(const Flags& flags) {
  if (!flags.listen_insecure) return flags.security;
  SecurityOptions security;
  security.insecure = true;
  security.reflection = flags.security.reflection;
  security.health_is_open = flags.security.health_is_open;
  security.audit_file = flags.security.audit_file;
  security.audit_bytes = flags.security.audit_bytes;
  return security;
}

// Returns how other programs on the robot reach it.
absl::StatusOr<ServerSecurity> MakeListenSecurity(const Flags& flags) {
  if (flags.listen.empty()) return ServerSecurity{};
  return MakeServerSecurity(ListenSecurityOf(flags), flags.mission, flags.agent);
}

absl::Status CheckListenSecurity(const Flags& flags) {
  if (flags.listen.empty()) return absl::OkStatus();
  return CheckServerSecurity(ListenSecurityOf(flags), flags.mission, flags.agent);
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

std::vector<absl::Status> CheckPlaces(const Flags& flags) {
  std::vector<absl::Status> found;
  if (!flags.server.empty()) found.push_back(CheckFlagServer("--server", flags.server));
  if (!flags.listen.empty()) found.push_back(CheckFlagAddress("--listen", flags.listen));
  if (!flags.spool.folder.empty()) found.push_back(CheckFolder("--spool", flags.spool.folder));
  found.push_back(CheckSpoolFlags(flags.spool, !flags.server.empty()));
  if (flags.server.empty()) found.push_back(CheckNoLinkFlags(flags.link));
  const bool has_server = !flags.server.empty();
  found.push_back(CheckMemoryFlags(flags.memory, flags.share, flags.outbox_mb << 20,
                                   has_server || !flags.spool.folder.empty()));
  found.push_back(CheckSettingsFlags(flags.settings, has_server));
  found.push_back(CheckShareFlags(ShareOf(flags), has_server));
  found.push_back(CheckPace(flags));
  found.push_back(CheckLocaliseOnly(flags));
  found.push_back(CheckRecording(flags.record));
  for (const std::string& file :
       {flags.stats, flags.trajectory, flags.held_map, flags.settings.kept}) {
    if (!file.empty()) found.push_back(CheckFolderOf(file));
  }
  const std::vector<absl::Status> observing = CheckObserving(flags.observe);
  found.insert(found.end(), observing.begin(), observing.end());
  return found;
}

std::vector<absl::Status> Check(const Flags& flags) {
  std::vector<absl::Status> found = {
      CheckNameSegment("--mission", flags.mission),
      CheckNameSegment("--agent", flags.agent),
      MakeStoreChannel(flags).status(),
      CheckListenSecurity(flags),
      CheckVocabulary(flags.vocabulary),
      ParseUpload(flags).status(),
      CheckFlaggedSource(flags),
  };
  const std::vector<absl::Status> places = CheckPlaces(flags);
  found.insert(found.end(), places.begin(), places.end());
  return found;
}

absl::Status Run(const Flags& given_flags) {
  RETURN_IF_ERROR(CheckNameSegment("--mission", given_flags.mission));
  RETURN_IF_ERROR(CheckNameSegment("--agent", given_flags.agent));
  // The places are checked first: hours of mapping must not be lost because of a folder that isn't
  // there.
  for (const absl::Status& place : CheckPlaces(given_flags)) RETURN_IF_ERROR(place);
  RETURN_IF_ERROR(ParseUpload(given_flags).status());
  const auto orders = std::make_shared<AgentOrders>();
  const auto rate = std::make_shared<FrameRateLimit>();
  ASSIGN_OR_RETURN(const std::shared_ptr<grpc::Channel> channel, MakeStoreChannel(given_flags));
  ASSIGN_OR_RETURN(const std::unique_ptr<LiveSettings> settings,
                   MakeLiveSettings(given_flags, orders, rate));
  const Flags flags = With(settings->Begin(channel), given_flags);
  ASSIGN_OR_RETURN(const FeatureSelection upload, ParseUpload(flags));
  ASSIGN_OR_RETURN(std::unique_ptr<Spool> spool,
                   OpenSpool(flags.spool, AgentName(flags.mission, flags.agent)));
  // The uplink outlives the agent, which closes it.
  const std::unique_ptr<Uplink> uplink = MakeUplink(flags, channel, *settings);
  ASSIGN_OR_RETURN(const auto observers,
                   RobotObservers::Make(flags.observe, flags.mission, flags.agent));
  if (uplink != nullptr) {
    observers->LogSessions({flags.server, kMapStoreService, flags.security});
  }
  ASSIGN_OR_RETURN(ServerSecurity security, MakeListenSecurity(flags));
  LOG(INFO) << WhoOf(flags) << DescribeStart(flags);
  const StopWatcher stop;
  ASSIGN_OR_RETURN(const auto vocabulary, Vocabulary::Load(flags.vocabulary));
  const absl::StatusOr<RobotSource> opened = OpenFlaggedSource(flags, stop.stopped());
  // It was stopped while it waited for who drives its camera.
  if (absl::IsCancelled(opened.status())) return absl::OkStatus();
  RETURN_IF_ERROR(opened.status());
  const RobotSource& source = *opened;
  LogSource(source);
  const SensorCalibration& calibration = source.stream->calibration();
  RETURN_IF_ERROR(CheckPosesOf(calibration, flags.poses_of));
  ASSIGN_OR_RETURN(const RecordedCamera recorded, RecordedCameraOf(calibration));
  AgentOptions options = MakeAgentOptions(flags, upload, calibration);
  if (uplink != nullptr || !flags.listen.empty()) options.orders = orders;
  if (uplink != nullptr) observers->LogEvents(options.events);
  if (channel != nullptr) options.ask_place = MakePlaceAsker(channel, flags.mission);
  if (options.max_map_bytes > 0) {
    LOG(INFO) << "memory budget: " << (flags.memory.budget_bytes >> 20) << " MiB, of which "
              << (options.max_map_bytes >> 20) << " MiB are for the local map in use"
              << (flags.share.mode.has_value() || flags.server.empty()
                      ? ""
                      : "; --share is nearby, because of it");
  }
  ASSIGN_OR_RETURN(const auto recorder,
                   StartRecording(flags.record,
                                  {options, flags.source, flags.pace, uplink != nullptr,
                                   vocabulary->fingerprint()},
                                  *source.stream));
  ASSIGN_OR_RETURN(const auto agent,
                   Agent::Create(options, calibration, vocabulary, observers->Watch(uplink.get()),
                                 std::move(spool)));
  settings->GiveMask();
  Agent* const watched = observers->Watch(agent.get());
  const auto recording =
      recorder != nullptr ? recorder->Watch(watched, options.orders.get()) : nullptr;
  const auto minutes = observers->LogEachMinute(agent.get());
  AgentService service(agent.get(), uplink.get(),
                       {.mission = uplink != nullptr ? flags.mission : "",
                        .agent = flags.agent,
                        .recorded_camera = recorded,
                        .session = observers->OfSessions(),
                        .orders = options.orders,
                        .events = options.events});
  ASSIGN_OR_RETURN(const auto metrics, observers->Serve(agent.get(), uplink.get()));
  security.server.rpc_observer = observers->OfCalls();
  std::unique_ptr<Server> server;
  if (!flags.listen.empty()) {
    ASSIGN_OR_RETURN(server, Server::Start(flags.listen, {&service}, security.server));
    LOG(INFO) << WhoOf(flags) << "serves " << server->address() << " "
              << DescribeServing(ListenSecurityOf(flags));
    AnnounceAddress(server->address());
  }
  PlayedFrames frames;
  const absl::Status played = PlayStream(
      *source.stream, recording != nullptr ? *recording : *watched, flags.pace, stop.stopped(),
      frames,
      [&](const TrackingResult& result, uint64_t dropped) {
        observers->SetDropped(dropped);
        if (recorder != nullptr) recorder->OnResult(result, dropped);
        if (server != nullptr) service.OnFrame(result, dropped);
      },
      rate.get());
  // What became of the recording is in the log: it is no failure of the robot.
  if (recorder != nullptr) recorder->Finish().IgnoreError();
  // A frame that can't be read ends the drive, but what was mapped until then stays.
  const absl::Status finished = agent->Finish(absl::Seconds(flags.finish_s));
  if (flags.stay && played.ok() && finished.ok()) {
    AnnounceFinished();
    stop.stopped().WaitForNotification();
  }
  RobotReport report = MakeReport(flags, *agent, source, frames, uplink.get());
  report.settings = settings->Report();
  RETURN_IF_ERROR(WriteResults(flags, *agent, calibration, report));
  RETURN_IF_ERROR(AsFailure(played));
  RETURN_IF_ERROR(CheckTracked(report));
  return AsFailure(finished);
}

void AddFlags(CLI::App& app, Flags& flags) {
  app.add_option("--source", flags.source, SourceUsage() + ", with options: kitti:DIR?frames=0:120")
      ->required();
  app.add_flag_callback(
      "--sources",
      [] {
        std::printf("%s", ListSources().c_str());
        throw CLI::Success();
      },
      "Say what can be played and what each kind needs, and end");
  app.add_option("--rig", flags.rig, "Rig file of the cameras, instead of the source's own");
  app.add_option("--frames", flags.frames, "First and last frame, A:B, as ?frames=")
      ->group(kRareGroup);
  app.add_option("--server", flags.server, "HOST:PORT of a map store; without: one robot alone");
  app.add_option("--mission", flags.mission, "The exploration that is shared")
      ->capture_default_str();
  app.add_option("--agent", flags.agent, "This robot's name in it")->capture_default_str();
  app.add_option("--pace", flags.pace,
                 "sensor: drop what comes too fast; max: wait; step: in lockstep")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Pace>{
          {"sensor", Pace::kSensor}, {"max", Pace::kMax}, {"step", Pace::kStep}}))
      ->type_name("max|sensor|step")
      ->default_str("max");
  app.add_option("--listen", flags.listen, "HOST:PORT for other programs on the robot");
  app.add_option("--stats", flags.stats, "File to write statistics to, as JSON");
  app.add_option(
         "--held-map", flags.held_map,
         "File for what the robot holds of its own and others' map in the end, for pictures")
      ->group(kRareGroup);
  app.add_option("--trajectory", flags.trajectory,
                 "File for the trajectory, as TUM; of further local maps: FILE.2 and so on");
  app.add_option("--poses-of", flags.poses_of,
                 "Of --trajectory: camera (as recorded, the left one), rectified or body")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, PosesOf>{{"camera", PosesOf::kRecordedCamera},
                                         {"rectified", PosesOf::kRectifiedCamera},
                                         {"body", PosesOf::kBody}}))
      ->type_name("FRAME")
      ->default_str("camera");
  app.add_option("--vocabulary", flags.vocabulary, "File of the bag of words")
      ->capture_default_str();
  app.add_option("--features", flags.features,
                 "Features of a picture; 0: 2000 for stereo, 1000 for RGB-D")
      ->check(CLI::Range(0, 20000))
      ->capture_default_str();
  app.add_option("--seed", flags.seed, "Of ids and random samples; 0: another one each time")
      ->capture_default_str()
      ->group(kRareGroup);
  app.add_option("--threads", flags.solver_threads, "Solver threads")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--finish", flags.finish_s,
                 "Seconds to wait after the last frame until the map store has everything")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str()
      ->group(kRareGroup);
  AddSpoolFlags(app, flags.spool);
  app.add_option("--outbox-mb", flags.outbox_mb,
                 "MiB that wait in memory, the rest waits in --spool alone; 0: everything does")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str()
      ->group(kRareGroup);
  app.add_option("--upload", flags.upload,
                 "What goes up of a keyframe: features=all, =mapped or =N")
      ->capture_default_str();
  AddLinkFlags(app, flags.link);
  AddShareFlags(app, flags.share);
  AddMemoryFlags(app, flags.memory);
  AddSettingsFlags(app, flags.settings, flags.max_rate_hz);
  AddRecordFlags(app, flags.record);
  app.add_flag("--localise-only", flags.localise_only,
               "Map nothing: track the camera in what others mapped")
      ->group(kRareGroup);
  app.add_flag("--strict", flags.strict,
               "Refuse a source in which something looks wrong, instead of warning");
  app.add_flag("--take-over", flags.take_over,
               "Take the place of another process of this name that is connected");
  app.add_flag("--stay", flags.stay,
               "At the end say \"finished\" and stay connected until SIGTERM");
  AddTlsFlags(app, flags.security);
  AddServerFlags(app, flags.security);
  AddClientFlags(app, flags.security);
  AddMetricsFlag(app, flags.observe);
  AddTraceFlag(app, flags.observe);
  app.add_flag("--listen-insecure", flags.listen_insecure,
               "Without TLS on --listen only, for a loopback address");
}

}  // namespace

int RunRobot(const std::string& program, int argc, char** argv) {
  BlockStopSignals();
  RegisterLiveSources();
  Flags flags;
  CLI::App app("One robot of a shared exploration", program);
  AddFlags(app, flags);
  const auto run = [&] {
    flags.given = GivenFlags(app);
    return Run(flags);
  };
  return RunProgram(app, argc, argv, {run, [&] { return Check(flags); }});
}

}  // namespace corbslam::services

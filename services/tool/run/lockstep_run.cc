#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/agent/agent.h"
#include "fusion_worker/local_fusion_worker.h"
#include "map_store/store/map_store.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/programs/robot/agent_run.h"
#include "services/programs/robot/held_map_file.h"
#include "services/programs/robot/inspected_source.h"
#include "services/programs/robot/pictures_time.h"
#include "services/programs/robot/robot_report.h"
#include "services/programs/robot/source_json.h"
#include "services/programs/robot/told_poses.h"
#include "services/server/process_usage.h"
#include "services/server/server.h"
#include "services/tool/run/direct_uplink.h"
#include "services/tool/run/mission_run.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::FormatSourceSpec;
using client_agent::FrameStream;
using client_agent::NextFrame;
using client_agent::StreamFrame;
using client_agent::TrackingResult;
using fusion_worker::FusionWorkerOptions;
using fusion_worker::MakeLocalFusionWorker;
using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

constexpr absl::Duration kFinishTimeout = absl::Minutes(10);
constexpr size_t kProgressEvery = 10;  // In frames.
// The same numbers as client_agent's defaults.
constexpr int kStereoFeatures = 2000;
constexpr int kRgbdFeatures = 1000;
constexpr uint64_t kSeed = 1;

struct LockstepRobot {
  RobotPlan plan;
  absl::Status failure;  // What ended the robot's drive early, or kept it from beginning.
  InspectedSource opened;
  std::optional<int> drive;  // Drive of the last frame.
  std::unique_ptr<DirectUplink> uplink;
  std::unique_ptr<Agent> agent;  // Destroyed before the uplink. Null if it could not begin.
  size_t frames = 0;
  RelocalisationCount relocalised;
  std::optional<ToldPoses> told;  // Where the robot could begin.
  bool has_ended = false;
};

// Does everything on the caller's thread.
class Lockstep {
 public:
  Lockstep(const MissionRunOptions& options, const ProgressListener& on_progress)
      : options_(options), on_progress_(on_progress) {}

  absl::StatusOr<MissionOutcome> Run();

 private:
  absl::Status StartStore();
  // Adds a robot; one whose source can't be opened is added too, without an agent.
  void AddRobot(const RobotPlan& plan);
  absl::Status OpenRobot(LockstepRobot& robot);
  // Plays robots [first, end) to their ends.
  absl::Status Play(size_t first, size_t end);
  absl::Status TakeFrame(LockstepRobot& robot);
  absl::Status Settle();
  absl::StatusOr<MissionOutcome> ReadAll();
  void ShowProgress(const std::string& stage) const;

  const MissionRunOptions& options_;
  const ProgressListener& on_progress_;
  // What runs before this one in the same process is not this one's cost.
  const double cpu_before_s_ = GetProcessUsage().cpu_s;
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::unique_ptr<FusionWorker> worker_;
  std::unique_ptr<MapStore> store_;
  std::vector<LockstepRobot> robots_;  // Destroyed before the store.
};

absl::Status Lockstep::StartStore() {
  const std::string path =
      options_.vocabulary_path.empty() ? DefaultVocabularyPath() : options_.vocabulary_path;
  ASSIGN_OR_RETURN(vocabulary_, Vocabulary::Load(path));
  FusionWorkerOptions worker_options;
  worker_options.seed = options_.seed.value_or(kSeed);
  worker_ = MakeLocalFusionWorker(worker_options);
  MapStoreOptions store_options;
  store_options.deterministic = true;
  store_ = std::make_unique<MapStore>(store_options, vocabulary_,
                                      std::make_unique<InMemoryJournal>(), worker_.get());
  return absl::OkStatus();
}

void Lockstep::AddRobot(const RobotPlan& plan) {
  LockstepRobot robot;
  robot.plan = plan;
  robot.failure = OpenRobot(robot);
  robot.has_ended = !robot.failure.ok();
  robots_.push_back(std::move(robot));
}

absl::Status Lockstep::OpenRobot(LockstepRobot& robot) {
  ASSIGN_OR_RETURN(robot.opened, OpenInspectedSource(robot.plan.source, options_.strict));
  const SensorCalibration& calibration = robot.opened.source->calibration();
  robot.uplink = std::make_unique<DirectUplink>(store_.get());
  AgentOptions options;
  options.mission = options_.mission;
  options.name = robot.plan.name;
  options.seed = options_.seed.value_or(kSeed);
  options.deterministic = true;
  if (options_.alone) options.share.mode = ShareMode::kNone;
  const bool is_rgbd = KindOf(calibration) == SensorKind::kRgbd;
  options.sensor.orb.features = is_rgbd ? kRgbdFeatures : kStereoFeatures;
  ASSIGN_OR_RETURN(const RecordedCamera recorded, RecordedCameraOf(calibration));
  robot.told.emplace(recorded);
  ASSIGN_OR_RETURN(robot.agent,
                   Agent::Create(options, calibration, vocabulary_, robot.uplink.get()));
  return absl::OkStatus();
}

absl::Status Lockstep::TakeFrame(LockstepRobot& robot) {
  if (robot.has_ended) return absl::OkStatus();
  ASSIGN_OR_RETURN(const NextFrame next, robot.opened.source->Next(absl::InfiniteFuture()));
  const auto* taken = std::get_if<StreamFrame>(&next);
  if (taken == nullptr) {
    robot.has_ended = true;
    return absl::OkStatus();
  }
  ++robot.frames;
  const int drive = taken->frame.drive;
  if (robot.drive.value_or(drive) != drive) robot.agent->BeginLocalMap();
  robot.drive = drive;
  ASSIGN_OR_RETURN(const TrackingResult result, robot.agent->Track(taken->images));
  robot.relocalised.Add(result);
  robot.told->Add(result);
  return absl::OkStatus();
}

// Lets the store fuse until it is idle, then hands out what is new.
absl::Status Lockstep::Settle() {
  // Where no robot could begin, there is no mission.
  const absl::Status fused = store_->RunFusionUntilIdle(options_.mission);
  if (!absl::IsNotFound(fused)) RETURN_IF_ERROR(fused);
  for (LockstepRobot& robot : robots_) {
    if (robot.agent == nullptr) continue;
    robot.uplink->DeliverShared();
    robot.agent->Step();
  }
  return absl::OkStatus();
}

absl::Status Lockstep::Play(size_t first, size_t end) {
  for (size_t step = 0, playing = end - first; playing > 0; ++step) {
    playing = 0;
    for (size_t i = first; i < end; ++i) {
      LockstepRobot& robot = robots_[i];
      // An error in one robot's pictures ends only that robot's drive.
      if (const absl::Status taken = TakeFrame(robot); !taken.ok()) {
        robot.failure = taken;
        robot.has_ended = true;
      }
      if (!robot.has_ended) ++playing;
    }
    RETURN_IF_ERROR(Settle());
    if (step % kProgressEvery == 0) ShowProgress("mapping");
  }
  ShowProgress("fusing");
  for (size_t i = first; i < end; ++i) {
    if (robots_[i].agent != nullptr) RETURN_IF_ERROR(robots_[i].agent->Finish(kFinishTimeout));
  }
  return Settle();
}

void Lockstep::ShowProgress(const std::string& stage) const {
  if (on_progress_ == nullptr) return;
  Progress progress;
  progress.stage = stage;
  for (const LockstepRobot& robot : robots_) {
    if (robot.agent == nullptr) continue;
    progress.robots.push_back(
        {robot.plan.name, absl::StrCat(robot.frames, "/", robot.opened.source->size())});
  }
  on_progress_(progress);
}

void DescribeSource(const LockstepRobot& robot, RobotReport& report) {
  const FrameStream& source = *robot.opened.source;
  PlayedFrames played;
  played.played = robot.frames;
  report.pictures_s = PicturesTime_s(source, robot.frames);
  report.left_out = static_cast<int>(source.left_out().count);
  report.source_description = ToJson(robot.opened.description);
  report.warnings =
      ToReportWarnings(CollectWarnings(robot.opened.warnings, *robot.agent, source, played));
}

RobotReport Report(const LockstepRobot& robot) {
  RobotReport report;
  if (robot.agent != nullptr) {
    report = MakeRobotReport(*robot.agent);
    DescribeSource(robot, report);
    report.relocalised = robot.relocalised.all();
    report.shared_relocalised = robot.relocalised.by_others();
    AddJumps(robot.told->jumps(), report);
    report.bytes_up = robot.uplink->bytes_up();
    report.bytes_down = robot.uplink->bytes_down();
  }
  if (!robot.failure.ok()) {
    report.warnings.push_back({"", "robot-failed", std::string(robot.failure.message())});
  }
  report.name = robot.plan.name;
  report.source = FormatSourceSpec(robot.plan.source);
  return report;
}

absl::StatusOr<MissionOutcome> Lockstep::ReadAll() {
  MapStoreService service(store_.get());
  ASSIGN_OR_RETURN(const std::unique_ptr<Server> server, Server::Start("", {&service}));
  StoreReader reader(server->InProcessChannel(), options_.mission);
  MissionOutcome outcome;
  RETURN_IF_ERROR(ReadOutcome(reader, options_, outcome));
  for (size_t i = 0; i < robots_.size(); ++i) {
    const LockstepRobot& robot = robots_[i];
    if (robot.told.has_value()) outcome.paths[i].told = robot.told->paths();
    outcome.report.robots.push_back(Report(robot));
    outcome.held.push_back(robot.agent == nullptr ? std::nullopt : GetHeldMap(*robot.agent));
    for (const ReportWarning& warning : outcome.report.robots.back().warnings) {
      if (warning.code != "robot-failed" && warning.code != "nothing-tracked") continue;
      outcome.failures.push_back(absl::StrCat(robot.plan.name, ": ", warning.text));
    }
  }
  const ProcessUsage usage = GetProcessUsage();
  outcome.report.servers["corbslam"] = {static_cast<double>(usage.peak_rss_bytes) / (1 << 20),
                                        usage.cpu_s - cpu_before_s_};
  server->Shutdown(absl::Seconds(5));
  return outcome;
}

absl::StatusOr<MissionOutcome> Lockstep::Run() {
  RETURN_IF_ERROR(StartStore());
  for (size_t i = 0; i < options_.robots.size(); ++i) {
    AddRobot(options_.robots[i]);
    if (options_.sequential) RETURN_IF_ERROR(Play(i, i + 1));
  }
  if (!options_.sequential) RETURN_IF_ERROR(Play(0, robots_.size()));
  return ReadAll();
}

}  // namespace

absl::StatusOr<MissionOutcome> RunLockstep(const MissionRunOptions& options,
                                           const ProgressListener& on_progress) {
  return Lockstep(options, on_progress).Run();
}

}  // namespace corbslam::services

#include "services/ros2/ros2_companion.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/ros2/ros2_service.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::NearMap;
using client_agent::Ros2CameraState;
using client_agent::Ros2Settings;
using client_agent::TrackingResult;

namespace {

constexpr absl::Duration kPeriod = absl::Seconds(1);

double Milliseconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace

Ros2Companion::~Ros2Companion() {
  // Services and listeners hold on to this companion.
  context_->Stop();
  stop_.Notify();
  if (worker_.joinable()) worker_.join();
}

absl::Status Ros2Companion::Prepare() {
  RETURN_IF_ERROR(context_->Begin());
  ASSIGN_OR_RETURN(outputs_,
                   Ros2Outputs::Make(context_->names(), context_->settings(), context_->node()));
  worker_ = StartThread("ros2 companion", [this] { Work(); });
  return absl::OkStatus();
}

absl::Status Ros2Companion::Begin(const RobotView& robot) {
  const Ros2Settings& settings = context_->settings();
  mounting_ = MakeMounting(robot.recorded, settings.map_from_global, robot.has_store);
  const Ros2CameraState camera = context_->camera();
  if (camera.base_is_of_rig && settings.publish_base_to_camera_tf) {
    outputs_->PublishBaseToCamera(camera.camera_frame, *robot.recorded.body_from_recorded);
  }
  if (!settings.publish_odom_to_base_tf && settings.publish_map_to_odom_tf) LeaveOdomToOthers();
  RETURN_IF_ERROR(Serve(robot));
  const absl::MutexLock lock(&robot_mutex_);
  robot_ = robot;
  name_ = robot.name;
  return absl::OkStatus();
}

void Ros2Companion::LeaveOdomToOthers() {
  const Ros2Settings& settings = context_->settings();
  context_->frames().SetListener(
      settings.odom_frame, settings.base_frame,
      [this](int64_t timestamp_ns, const Rigid3d& odom_from_base) {
        outputs_->PublishMapToOdom(outside_.AddOdom(timestamp_ns, odom_from_base));
      });
}

absl::Status Ros2Companion::Serve(const RobotView& robot) {
  const auto& names = context_->names();
  const auto orders = robot.orders;
  RETURN_IF_ERROR(
      client_agent::ServeTrigger(context_->node(), names.Resolve("visual_slam/reset"),
                                 [orders]() -> absl::StatusOr<std::string> {
                                   RETURN_IF_ERROR(orders->OpenLocalMap());
                                   return "another local map begins with the next frame";
                                 }));
  return client_agent::ServeSetBool(
      context_->node(), names.Resolve("visual_slam/pause_mapping"),
      [orders](bool paused) -> absl::StatusOr<std::string> {
        RETURN_IF_ERROR(orders->PauseMapping(paused));
        return paused ? "mapping is paused; the robot is tracked in what there is"
                      : "mapping goes on";
      });
}

void Ros2Companion::OnFrame(const TrackingResult& result, const FrameMoment& moment) {
  const Ros2Settings& settings = context_->settings();
  const Ros2Poses poses = MakePoses(result, mounting_);
  outputs_->PublishPoses(poses);
  const bool hangs_on_others = !settings.publish_odom_to_base_tf && settings.publish_map_to_odom_tf;
  if (hangs_on_others && poses.map_from_base.has_value()) {
    outputs_->PublishMapToOdom(outside_.AddMap(poses.timestamp_ns, *poses.map_from_base));
  }
  ++frame_count_;
  if (poses.odom_from_base.has_value()) ++pose_count_;
  Keep(poses, moment);
}

void Ros2Companion::Keep(const Ros2Poses& poses, const FrameMoment& moment) {
  const std::optional<int64_t> now_ns = context_->clock().Now_ns();
  const absl::MutexLock lock(&frames_mutex_);
  if (poses.local_map != frames_.local_map) frames_.path.clear();
  frames_.local_map = poses.local_map;
  if (poses.map_from_local.has_value()) frames_.map_from_local = poses.map_from_local;
  if (poses.local_from_base.has_value()) {
    frames_.path.push_back({poses.timestamp_ns, *poses.local_from_base});
    frames_.latency_ms = Milliseconds(std::chrono::steady_clock::now() - moment.came);
  }
  if (frames_.path.size() > static_cast<size_t>(context_->settings().path_max_size)) {
    frames_.path.pop_front();
  }
  frames_.dropped = moment.dropped;
  frames_.stamp_ahead_s.reset();
  if (now_ns.has_value()) {
    frames_.stamp_ahead_s = 1e-9 * static_cast<double>(poses.timestamp_ns - *now_ns);
  }
}

void Ros2Companion::OnEnd() {
  context_->frames().SetListener("", "", nullptr);
  const absl::MutexLock lock(&robot_mutex_);
  robot_.reset();
  has_ended_ = true;
}

void Ros2Companion::Work() {
  while (!stop_.WaitForNotificationWithTimeout(kPeriod)) {
    const absl::MutexLock lock(&robot_mutex_);
    const Ros2Facts facts = Collect();
    TellSilence(facts);
    // Before /clock has said anything there is no time to stamp with.
    const std::optional<int64_t> now_ns = context_->clock().Now_ns();
    if (now_ns.has_value()) outputs_->PublishDiagnoses(Diagnose(facts), *now_ns, name_);
    PublishMap();
  }
}

void Ros2Companion::PublishMap() {
  if (!robot_.has_value()) return;
  std::vector<StampedMotion> path;
  std::optional<Similarity3d> map_from_local;
  LocalMapId local_map;
  {
    const absl::MutexLock lock(&frames_mutex_);
    map_from_local = frames_.map_from_local;
    local_map = frames_.local_map;
    if (map_from_local.has_value() && outputs_->PathIsWanted()) {
      path.assign(frames_.path.begin(), frames_.path.end());
    }
  }
  if (!map_from_local.has_value()) return;
  for (StampedMotion& pose : path) pose.motion = Moved(*map_from_local, pose.motion);
  outputs_->PublishPath(path);
  if (!outputs_->CloudIsWanted()) return;
  const std::optional<NearMap> near =
      robot_->agent->GetNearMap({.radius_m = context_->settings().near_map_radius_m});
  // Another local map may have begun meanwhile.
  if (near.has_value() && near->local_map == local_map) {
    outputs_->PublishCloud(*near, *map_from_local);
  }
}

std::vector<std::string> Ros2Companion::Conflicts() const {
  const Ros2Settings& settings = context_->settings();
  std::vector<std::string> conflicts;
  const auto look = [&](bool publishes, const std::string& child) {
    const std::string parent = publishes ? context_->frames().OthersParentOf(child) : "";
    if (!parent.empty()) conflicts.push_back(absl::StrCat(parent, " -> ", child));
  };
  look(settings.publish_odom_to_base_tf, settings.base_frame);
  look(settings.publish_map_to_odom_tf, settings.odom_frame);
  return conflicts;
}

Ros2Facts Ros2Companion::Collect() {
  Ros2Facts facts;
  const Ros2Settings& settings = context_->settings();
  const Ros2CameraState camera = context_->camera();
  facts.has_begun = robot_.has_value();
  facts.has_ended = has_ended_;
  facts.waits_for = camera.problem;
  facts.use_sim_time = settings.use_sim_time;
  for (const size_t side : {size_t{0}, size_t{1}}) {
    facts.image_topics[side] = settings.images[side].topic;
    if (facts.has_begun && camera.images[side] != nullptr) {
      facts.flow.pictures[side] = camera.images[side]->Hearing().messages;
    }
  }
  facts.flow.frames = frame_count_;
  facts.flow.poses = pose_count_;
  facts.conflicts = Conflicts();
  facts.unmatched = outside_.unmatched();
  if (facts.has_begun) {
    facts.silence = silence_.Tell(facts.flow, std::chrono::steady_clock::now());
    facts.silent_for_s = std::chrono::duration<double>(silence_.silent_for()).count();
    facts.agent = robot_->agent->GetStatus();
    if (robot_->session != nullptr) facts.session = robot_->session();
  }
  const absl::MutexLock lock(&frames_mutex_);
  facts.dropped = frames_.dropped;
  facts.latency_ms = frames_.latency_ms;
  facts.stamp_ahead_s = frames_.stamp_ahead_s;
  return facts;
}

void Ros2Companion::TellSilence(const Ros2Facts& facts) {
  if (facts.silence == told_silence_) return;
  if (facts.silence != Silence::kNone) {
    LOG(WARNING) << "ros2: " << Describe(facts.silence, facts.silent_for_s, facts.image_topics);
  } else {
    LOG(INFO) << "ros2: poses go out again";
  }
  told_silence_ = facts.silence;
}

}  // namespace corbslam::services

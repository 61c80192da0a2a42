#include "client_agent/agent/single_agent.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/agent/trajectory_log.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// The agent's name makes the ids of two agents with one seed differ (FNV-1a).
uint64_t SeedOf(const AgentOptions& options) {
  uint64_t hash = 14695981039346656037ull ^ options.seed;
  for (const char c : options.name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

StoreLinkOptions MakeStoreLinkOptions(const AgentOptions& options,
                                      const RecordedCamera& recorded_camera) {
  StoreLinkOptions link;
  link.mission = options.mission;
  link.agent = options.name;
  link.recorded_camera = recorded_camera;
  link.seed = SeedOf(options);
  link.max_outbox_bytes = options.max_outbox_bytes;
  link.features = options.upload_features;
  link.uplink_bytes_per_second = options.uplink_bytes_per_second;
  link.downlink_bytes_per_second = options.downlink_bytes_per_second;
  return link;
}

}  // namespace

absl::Status AgentOptions::Validate() const {
  if (name.empty()) return absl::InvalidArgumentError("agent options: the name is empty");
  if (mission.empty()) return absl::InvalidArgumentError("agent options: the mission is empty");
  if (solver_threads < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("agent options: solver_threads is ", solver_threads, ", not at least 1"));
  }
  return sensor.orb.Validate();
}

absl::StatusOr<std::unique_ptr<Agent>> Agent::Create(const AgentOptions& options,
                                                     const SensorCalibration& calibration,
                                                     std::shared_ptr<const Vocabulary> vocabulary,
                                                     Uplink* uplink, std::unique_ptr<Spool> spool) {
  RETURN_IF_ERROR(options.Validate());
  if (vocabulary == nullptr) return absl::InvalidArgumentError("agent: no vocabulary");
  ASSIGN_OR_RETURN(std::unique_ptr<Sensor> sensor, MakeSensor(calibration, options.sensor));
  ASSIGN_OR_RETURN(const RecordedCamera recorded_camera, RecordedCameraOf(calibration));
  return std::make_unique<SingleAgent>(options, std::move(sensor), calibration, recorded_camera,
                                       std::move(vocabulary), uplink, std::move(spool));
}

SingleAgent::SingleAgent(const AgentOptions& options, std::unique_ptr<Sensor> sensor,
                         const SensorCalibration& calibration,
                         const RecordedCamera& recorded_camera,
                         std::shared_ptr<const Vocabulary> vocabulary, Uplink* uplink,
                         std::unique_ptr<Spool> spool)
    : options_(options),
      is_stereo_(std::holds_alternative<StereoCalibration>(calibration)),
      created_(absl::Now()),
      sensor_(std::move(sensor)),
      input_watch_(calibration),
      camera_(std::make_shared<const Camera>(sensor_->camera())),
      vocabulary_(std::move(vocabulary)),
      random_(SeedOf(options)),
      link_(std::make_unique<StoreLink>(
          MakeStoreLinkOptions(options, recorded_camera), uplink,
          [vocabulary = vocabulary_](const std::vector<Descriptor>& descriptors) {
            return std::make_shared<const Words>(vocabulary->Transform(descriptors));
          },
          std::move(spool))) {
  OpenLocalMap();
  if (!options_.deterministic) link_->Start();
}

SingleAgent::~SingleAgent() {
  for (const LocalMapSession* session : Sessions()) const_cast<LocalMapSession*>(session)->Stop();
}

void SingleAgent::OpenLocalMap() {
  LocalMapSessionOptions options;
  while (!options.local_map.IsValid()) options.local_map.value = random_();
  options.tracker.seed = options_.seed;
  // Depths of RGB-D cameras are coarser than disparities.
  options.tracker.local_map_widening = is_stereo_ ? 1 : 3;
  options.mapper.local_bundle.threads = options_.solver_threads;
  options.loop_closer.seed = options_.seed;
  options.loop_closer.fix_scale = camera_->IsMetric();
  options.loop_closer.solver_threads = options_.solver_threads;
  options.follow_correction = [this, id = options.local_map](const OwnCorrection& correction,
                                                             Map& map) {
    link_->OnCorrected(id, correction, map);
  };
  auto session = std::make_unique<LocalMapSession>(options, camera_, vocabulary_);
  LocalMapSession* opened = session.get();
  MapAccess access;
  access.local_map = options.local_map;
  access.read = [opened](const std::function<void(const Map&)>& f) { opened->map().Read(f); };
  access.post = [opened](std::function<MapChange(const Map&)> prepare) {
    opened->queue().PostJob([prepare = std::move(prepare)](GuardedMap& map) {
      const MapChange change = map.Read(prepare);
      map.Write(change);
    });
  };
  access.on_placed = [opened](const PlacementChange& change, const Map& map) {
    opened->OnPlaced(change, map);
  };
  opened->map().SetObserver(link_->BeginLocalMap(std::move(access)));
  if (!options_.deterministic) opened->Start();
  absl::MutexLock lock(&mutex_);
  sessions_.push_back(std::move(session));
  current_session_ = opened;
  status_.local_maps = static_cast<int>(sessions_.size());
  status_.local_map = options.local_map;
}

absl::StatusOr<TrackingResult> SingleAgent::Track(const SensorImages& images) {
  const absl::Time start = absl::Now();
  ASSIGN_OR_RETURN(Features features, sensor_->Process(images));
  Watch(features);
  TrackingResult result = current().tracker().Track(images.timestamp_ns, std::move(features));
  Record(result, absl::ToDoubleMilliseconds(absl::Now() - start));
  if (current().tracker().IsLostForGood() || link_->NeedsNewLocalMap()) BeginLocalMap();
  if (options_.deterministic) Step();
  return result;
}

void SingleAgent::BeginLocalMap() {
  current().WaitUntilIdle(absl::Now() + absl::Seconds(1));
  current().Stop();
  OpenLocalMap();
}

void SingleAgent::Watch(const Features& features) {
  std::optional<SourceFinding> finding = input_watch_.Add(features);
  if (!finding.has_value()) return;
  absl::MutexLock lock(&mutex_);
  status_.input_findings.push_back(*std::move(finding));
}

void SingleAgent::Record(const TrackingResult& result, double tracking_ms) {
  const bool tracked = result.state == TrackingState::kTracking;
  const size_t foreign_keyframes = link_->shared_keyframes();
  {
    absl::MutexLock lock(&mutex_);
    status_.state = result.state;
    ++status_.frames;
    ++(tracked ? status_.tracked : status_.lost);
    tracking_ms_.push_back(tracking_ms);
    if (tracked) {
      status_.timestamp_ns = result.timestamp_ns;
      status_.local_from_camera = result.camera_from_local.Inverse();
      tracked_frames_.push_back(
          {result.timestamp_ns, result.reference, result.reference_from_camera});
    }
    if (tracked && foreign_keyframes > 0) {
      points_matched_ += result.points_matched;
      foreign_points_matched_ += result.foreign_points_matched;
    }
  }
  if (tracked) {
    link_->AddTrackedFrame({result.timestamp_ns, result.reference, result.reference_from_camera});
  } else {
    link_->AddLostFrame(result.timestamp_ns);
  }
}

void SingleAgent::Step() {
  if (!options_.deterministic) return;
  current().Step();
  link_->Step();
  // What came back while sending.
  current().Step();
}

absl::Status SingleAgent::Finish(absl::Duration timeout) {
  const absl::Time deadline = absl::Now() + timeout;
  if (!current().WaitUntilIdle(deadline)) {
    return absl::DeadlineExceededError("mapping and loop closing have not come to an end yet");
  }
  return link_->Finish(deadline - absl::Now());
}

std::vector<const LocalMapSession*> SingleAgent::Sessions() const {
  absl::MutexLock lock(&mutex_);
  std::vector<const LocalMapSession*> sessions;
  for (const auto& session : sessions_) sessions.push_back(session.get());
  return sessions;
}

std::optional<Similarity3d> SingleAgent::GlobalFromLocal() const {
  return link_->GlobalFromLocal();
}

AgentTimings SingleAgent::GetTimings() const {
  AgentTimings timings;
  {
    absl::MutexLock lock(&mutex_);
    timings.tracking_ms = tracking_ms_;
  }
  for (const LocalMapSession* session : Sessions()) {
    const std::vector<double> ms = session->mapper().local_ba_ms();
    timings.local_ba_ms.insert(timings.local_ba_ms.end(), ms.begin(), ms.end());
  }
  return timings;
}

AgentStatus SingleAgent::GetStatus() const {
  AgentStatus status;
  {
    absl::MutexLock lock(&mutex_);
    status = status_;
    if (points_matched_ > 0) {
      status.foreign_points_percent = 100.0 * static_cast<double>(foreign_points_matched_) /
                                      static_cast<double>(points_matched_);
    }
  }
  for (const LocalMapSession* session : Sessions()) {
    session->map().Read([&](const Map& map) {
      for (const auto& [id, keyframe] : map.keyframes()) {
        status.keyframes += session->map().IsOwn(id);
      }
      for (const auto& [id, point] : map.points()) status.map_points += session->map().IsOwn(id);
    });
    const LoopCloserCounts loops = session->loop_closer().counts();
    status.loops_closed += loops.closed;
    status.foreign_loops_closed += loops.closed_against_others;
  }
  status.global_from_local = link_->GlobalFromLocal();
  status.foreign_keyframes = static_cast<int>(link_->shared_keyframes());
  status.upload = link_->upload();
  if (const auto first = link_->first_acknowledged()) {
    status.first_upload_s = absl::ToDoubleSeconds(*first - created_);
  }
  return status;
}

std::vector<TrajectoryPose> SingleAgent::LocalTrajectory() const {
  std::vector<TrackedFrame> frames;
  {
    absl::MutexLock lock(&mutex_);
    frames = tracked_frames_;
  }
  std::vector<TrajectoryPose> trajectory;
  for (const LocalMapSession* session : Sessions()) {
    AppendTrajectory(frames, session->map(), trajectory);
  }
  return trajectory;
}

Map SingleAgent::CopyMap() const {
  return Sessions().back()->map().Read([](const Map& map) { return map; });
}

}  // namespace corbslam

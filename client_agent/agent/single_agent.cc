#include "client_agent/agent/single_agent.h"

#include <glog/logging.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/agent/contradiction_text.h"
#include "client_agent/agent/resuming.h"
#include "client_agent/agent/trajectory_log.h"
#include "client_agent/upload/held_back_items.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// What is left to map of a local map that ended gets so long.
constexpr absl::Duration kLongestEnd = absl::Seconds(1);
constexpr uint64_t kLeastToReturn_bytes = uint64_t{16} << 20;

// The agent's name makes the ids of two agents with one seed differ (FNV-1a).
uint64_t SeedOf(const AgentOptions& options) {
  uint64_t hash = 14695981039346656037ull ^ options.seed;
  for (const char c : options.name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

// Others' keyframes and points are placed in an own map by rigid motions, which a map without
// metres is not to theirs: its robot is told where its own keyframes stand, and no more.
ShareScope ShareOf(ShareScope share, bool may_take_others) {
  const bool has_others = share.mode == ShareMode::kNearby || share.mode == ShareMode::kEverything;
  if (has_others && !may_take_others) share.mode = ShareMode::kCorrections;
  return share;
}

// A robot that only localises has no map of its own that could lack metres.
bool MayTakeOthers(const AgentOptions& options, const Camera& camera) {
  return camera.IsMetric() || options.localise_only;
}

StoreLinkOptions MakeStoreLinkOptions(const AgentOptions& options, const Camera& camera,
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
  link.share = ShareOf(options.share, MayTakeOthers(options, camera));
  link.localise_only = options.localise_only;
  link.spool_within = options.spool_within;
  link.resumable = options.resume;
  if (options.events != nullptr) {
    link.on_event = [events = options.events](LinkEvent event, LocalMapId local_map) {
      events->NoteLink(event, local_map);
    };
  }
  if (options.activity != nullptr) {
    link.report = [activity = options.activity] { return activity->Report(); };
  }
  return link;
}

SheddingLimits MakeSheddingLimits(const AgentOptions& options) {
  SheddingLimits limits;
  limits.max_map_bytes = options.max_map_bytes;
  limits.radius_m = options.share.radius_m;
  return limits;
}

PlaceInquiryOptions MakeInquiryOptions(const AgentOptions& options) {
  PlaceInquiryOptions inquiry;
  inquiry.uplink_bytes_per_second = options.uplink_bytes_per_second;
  return inquiry;
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

absl::Status CheckParts(const AgentOptions& options, const Vocabulary* vocabulary,
                        const Uplink* uplink, const Spool* spool) {
  RETURN_IF_ERROR(options.Validate());
  if (options.localise_only && uplink == nullptr) {
    return absl::InvalidArgumentError(
        "agent: one that only localises needs a map store, and there is none");
  }
  if (vocabulary == nullptr) return absl::InvalidArgumentError("agent: no vocabulary");
  if (options.resume && (spool == nullptr || options.spool_within <= absl::ZeroDuration())) {
    return absl::InvalidArgumentError(
        "agent options: resume needs a spool, and spool_within greater than 0");
  }
  if (options.max_map_bytes > 0 && uplink == nullptr && spool == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("agent options: max_map_bytes is ", options.max_map_bytes,
                     ", but without an uplink or a spool there is nowhere for the rest of the map "
                     "to go"));
  }
  return absl::OkStatus();
}

absl::Status CheckCamera(const AgentOptions& options, const Camera& camera) {
  if (camera.IsMetric() || options.max_map_bytes == 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "agent options: max_map_bytes is ", options.max_map_bytes,
      ", and the camera is one alone: its map can't go on in another one, which would begin "
      "without "
      "depths and in another scale; leave the memory budget out, or use a stereo or RGB-D camera"));
}

// What an earlier process left: NOT_FOUND if there is nothing, or nothing is wanted of it.
absl::StatusOr<SpooledMap> TakeOverSpool(const AgentOptions& options, Spool* spool,
                                         const Camera& camera, const RecordedCamera& recorded) {
  if (spool == nullptr) return absl::NotFoundError("there is no spool");
  if (const absl::Status told = TellHeldBack(*spool); !told.ok()) {
    LOG(ERROR) << "what an earlier process held back when it ended is lost: " << told;
  }
  if (!options.resume) return absl::NotFoundError("it is not wanted");
  return FindMapToResume(*spool, camera, recorded);
}

absl::StatusOr<std::unique_ptr<Agent>> Agent::Create(const AgentOptions& options,
                                                     const SensorCalibration& calibration,
                                                     std::shared_ptr<const Vocabulary> vocabulary,
                                                     Uplink* uplink, std::unique_ptr<Spool> spool) {
  RETURN_IF_ERROR(CheckParts(options, vocabulary.get(), uplink, spool.get()));
  ASSIGN_OR_RETURN(std::unique_ptr<Sensor> sensor, MakeSensor(calibration, options.sensor));
  RETURN_IF_ERROR(CheckCamera(options, sensor->camera()));
  ASSIGN_OR_RETURN(const RecordedCamera recorded_camera, RecordedCameraOf(calibration));
  absl::StatusOr<SpooledMap> spooled_map =
      TakeOverSpool(options, spool.get(), sensor->camera(), recorded_camera);
  return std::make_unique<SingleAgent>(options, std::move(sensor), calibration, recorded_camera,
                                       std::move(vocabulary), uplink, std::move(spool),
                                       std::move(spooled_map));
}

SingleAgent::SingleAgent(const AgentOptions& options, std::unique_ptr<Sensor> sensor,
                         const SensorCalibration& calibration,
                         const RecordedCamera& recorded_camera,
                         std::shared_ptr<const Vocabulary> vocabulary, Uplink* uplink,
                         std::unique_ptr<Spool> spool, absl::StatusOr<SpooledMap> spooled_map)
    : options_(options),
      kind_(KindOf(calibration)),
      created_(absl::Now()),
      sensor_(std::move(sensor)),
      input_watch_(calibration),
      camera_(std::make_shared<const Camera>(sensor_->camera())),
      vocabulary_(std::move(vocabulary)),
      random_(SeedOf(options)),
      max_map_bytes_(options.max_map_bytes),
      shedder_(MakeSheddingLimits(options)),
      share_mode_(options.share.mode),
      inquiry_(options.ask_place, MakeInquiryOptions(options), !options.deterministic),
      link_(std::make_unique<StoreLink>(
          MakeStoreLinkOptions(options, *camera_, recorded_camera), uplink,
          [vocabulary = vocabulary_](const std::vector<Descriptor>& descriptors) {
            return std::make_shared<const Words>(vocabulary->Transform(descriptors));
          },
          std::move(spool), spooled_map.ok() ? spooled_map->local_map() : LocalMapId())),
      far_(MakeFarMaps(uplink != nullptr)),
      pictures_(uplink != nullptr ? MakePictureMaker(calibration) : nullptr),
      after_work_(/*threaded=*/!options.deterministic) {
  const auto imu = std::visit([](const auto& of) { return of.imu; }, calibration);
  if (imu.has_value() && kind_ != SensorKind::kMonocular) {
    inertial_.emplace(*imu, recorded_camera.camera_from_recorded);
  } else if (imu.has_value()) {
    SayFinding({FindingLevel::kWarning, "imu-unused",
                "the IMU is not used: it measures metres, and the map of one camera alone has "
                "none. Use a stereo or RGB-D camera beside it"});
  }
  if (options_.orders != nullptr) options_.orders->SetCamera(*camera_);
  if (spooled_map.ok()) resuming_ = Resuming{spooled_map->newest_ns(), std::nullopt};
  OpenLocalMap(std::nullopt, spooled_map.ok() ? &*spooled_map : nullptr);
  if (!spooled_map.ok() && options_.resume && !absl::IsNotFound(spooled_map.status())) {
    NoteNotResumed(std::string(spooled_map.status().message()));
  }
  if (options_.deterministic) return;
  link_->Start();
  if (far_ != nullptr) far_->Start();
}

SingleAgent::~SingleAgent() {
  if (far_ != nullptr) far_->Stop();
  current().Stop();
}

std::unique_ptr<PictureMaker> SingleAgent::MakePictureMaker(const SensorCalibration& calibration) {
  if (options_.picture_width_px == 0 || options_.deterministic || options_.localise_only) {
    return nullptr;
  }
  return std::make_unique<PictureMaker>(
      calibration, options_.picture_width_px,
      [this](KeyframePicture picture) { link_->AddPicture(std::move(picture)); });
}

void SingleAgent::OpenLocalMap(const std::optional<Similarity3d>& global_from_local,
                               const SpooledMap* spooled_map, bool goes_on) {
  LocalMapSessionOptions options;
  if (spooled_map != nullptr) options.local_map = spooled_map->local_map();
  while (!options.local_map.IsValid()) options.local_map.value = random_();
  options.tracker.seed = options_.seed;
  // Depths of RGB-D cameras are coarser than disparities.
  options.tracker.local_map_widening = kind_ == SensorKind::kRgbd ? 3 : 1;
  options.tracker.has_stereo = kind_ == SensorKind::kStereo;
  if (kind_ == SensorKind::kMonocular) options.tracker.keyframe = OfOneCamera();
  options.tracker.localise_only = options_.localise_only;
  options.tracker.max_lost_at_start_ns = absl::ToInt64Nanoseconds(options_.resume_wait);
  options.mapper.local_bundle.threads = options_.solver_threads;
  options.loop_closer.seed = options_.seed;
  options.loop_closer.fix_scale = camera_->IsMetric();
  options.loop_closer.solver_threads = options_.solver_threads;
  options.follow_correction = [this, id = options.local_map](const OwnCorrection& correction,
                                                             GuardedMap& map) {
    link_->OnCorrected(id, correction, map);
  };
  options.local_ba_ms = &local_ba_ms_;
  undescribed_.reset();
  current_session_ = std::make_shared<LocalMapSession>(options, camera_, vocabulary_);
  {
    absl::MutexLock lock(&mutex_);
    presumed_global_from_local_ = global_from_local;
  }
  if (spooled_map != nullptr) current().GoOnFrom(*spooled_map);
  link_->BeginLocalMap(current().map(), current(), spooled_map,
                       StoreLink::Earlier::kMayStillBeWritten);
  inquiry_.BeginLocalMap();
  if (far_ != nullptr) far_->BeginLocalMap(options.local_map, goes_on);
  if (!options_.deterministic) current().Start();
  absl::MutexLock lock(&mutex_);
  sessions_.push_back(current_session_);
  has_pose_ = false;
  ++status_.local_maps;
  status_.local_map = options.local_map;
}

void SingleAgent::LetGoOfFinished() {
  while (true) {
    std::shared_ptr<const LocalMapSession> oldest;
    {
      absl::MutexLock lock(&mutex_);
      if (letting_go_ || sessions_.size() < 2) return;
      oldest = sessions_.front();
      if (!oldest->has_stopped() || link_->Reads(oldest->map().local_map())) return;
      letting_go_ = true;
    }
    after_work_.Post([this, oldest = std::move(oldest)]() mutable { LetGoOf(std::move(oldest)); });
  }
}

void SingleAgent::LetGoOf(std::shared_ptr<const LocalMapSession> session) {
  const LocalMapId id = session->map().local_map();
  const auto is_of_it = [id](const TrackedFrame& frame) { return frame.reference.local_map == id; };
  std::vector<TrackedFrame> frames;
  {
    absl::MutexLock lock(&mutex_);
    std::ranges::copy_if(tracked_frames_, std::back_inserter(frames), is_of_it);
  }
  const OwnItems items = session->map().own_items();
  const LoopCloserCounts loops = session->loop_closer().counts();
  std::vector<TrajectoryPose> trajectory;
  AppendTrajectory(frames, session->map(), trajectory);
  KeepForReturn(*session);
  {
    absl::MutexLock lock(&mutex_);
    finished_.items.keyframes += items.keyframes;
    finished_.items.points += items.points;
    finished_.loops.closed += loops.closed;
    finished_.loops.closed_against_others += loops.closed_against_others;
    finished_.trajectory.insert(finished_.trajectory.end(), trajectory.begin(), trajectory.end());
    std::erase_if(tracked_frames_, is_of_it);
    sessions_.erase(sessions_.begin());
    letting_go_ = false;
  }
  session.reset();
  if (options_.deterministic) return;
  // The allocator's arenas would keep it: a long drive grew by a quarter of its budget.
  ReturnFreeMemoryAbove(kLeastToReturn_bytes);
}

absl::StatusOr<TrackingResult> SingleAgent::FindPose(const SensorImages& images) {
  Tracker& tracker = current().tracker();
  // Others' points are found by features, and so is the answer to a question.
  const bool needs_features = link_->shared_keyframes() > 0 ||
                              WantsToAsk(/*is_lost=*/false, link_->GlobalFromLocal().has_value());
  if (!needs_features && tracker.MayFollow(images.timestamp_ns)) {
    ASSIGN_OR_RETURN(const cv::Mat picture, sensor_->Picture(images));
    const std::optional<TrackingResult> followed =
        tracker.Follow({sensor_.get(), &images, HalvePicture(picture)});
    if (followed.has_value()) {
      if (tracker.WantsFeatures()) undescribed_ = {images, *followed};
      return *followed;
    }
  }
  ASSIGN_OR_RETURN(Features features, sensor_->Process(images));
  Watch(features);
  TrackingResult result =
      tracker.Track({.timestamp_ns = images.timestamp_ns, .features = std::move(features)});
  if (result.made_keyframe) RETURN_IF_ERROR(KeepPicture(result.reference, images));
  return result;
}

absl::Status SingleAgent::KeepPicture(KeyframeId keyframe, const SensorImages& images) {
  ASSIGN_OR_RETURN(const cv::Mat picture, sensor_->Picture(images));
  current().tracker().KeepPicture(HalvePicture(picture));
  if (pictures_ != nullptr && link_->WantsPictures()) pictures_->Add(keyframe, images.grey);
  return absl::OkStatus();
}

bool SingleAgent::HasMetres() const {
  if (camera_->IsMetric()) return true;
  return options_.localise_only && link_->GlobalIsInMetres();
}

bool SingleAgent::GlobalHasMetres() const {
  return camera_->IsMetric() || link_->GlobalIsInMetres();
}

absl::Status SingleAgent::UsePause() {
  if (!undescribed_.has_value()) return absl::OkStatus();
  auto [images, result] = *std::exchange(undescribed_, std::nullopt);
  ASSIGN_OR_RETURN(Features features, sensor_->Process(images));
  Watch(features);
  const KeyframeId keyframe = current().tracker().Describe(
      {.timestamp_ns = images.timestamp_ns, .features = std::move(features)});
  result.was_followed = false;
  LookForFar(result);
  return keyframe.IsValid() ? KeepPicture(keyframe, images) : absl::OkStatus();
}

absl::StatusOr<TrackingResult> SingleAgent::Track(const SensorImages& images) {
  const absl::Time start = absl::Now();
  RETURN_IF_ERROR(UsePause());
  FollowOrders();
  if (resuming_.has_value()) CheckTimeGoesOn(images.timestamp_ns);
  UseAnswer();
  ExpectByImu(images);
  ASSIGN_OR_RETURN(TrackingResult result, FindPose(images));
  LearnByImu(result);
  result.without_metres = !HasMetres();
  result.global_without_metres = !GlobalHasMetres();
  smooth_pose_.Add(result);
  LeaveOutContradicting();
  const bool is_placed = link_->GlobalFromLocal().has_value();
  result.global_from_local = GlobalFromLocal(result.corrections);
  Record(result, absl::ToDoubleMilliseconds(absl::Now() - start), is_placed);
  AskForPlace(result, is_placed);
  LookForFar(result);
  if (resuming_.has_value()) NoteResumed(result);
  if (!mapping_paused_ && (current().tracker().IsLostForGood() || link_->NeedsNewLocalMap())) {
    BeginLocalMap();
  }
  HandOverIfFull(result);
  if (options_.deterministic) {
    RETURN_IF_ERROR(UsePause());
    Step();
  }
  LetGoOfFinished();
  return result;
}

bool SingleAgent::WantsToAsk(bool is_lost, bool is_placed) const {
  // Who wants to be told nothing is not told where it is.
  if (share_mode_ == ShareMode::kNone) return false;
  // A lost robot can look where it is told only if it knows where that is in its map.
  return is_lost == is_placed && inquiry_.MayAsk(is_lost);
}

void SingleAgent::AskForPlace(const TrackingResult& result, bool is_placed) {
  const bool is_lost = result.why_no_pose == WhyNoPose::kNotRecognised ||
                       result.why_no_pose == WhyNoPose::kAnotherCamera;
  const bool is_tracked = result.state == TrackingState::kTracking;
  if (!is_lost && (!is_tracked || result.was_followed)) return;
  if (!WantsToAsk(is_lost, is_placed)) return;
  PlaceQuestion question{current().tracker().last_payload(), current().map().local_map(), {}};
  if (is_tracked) question.camera_from_local = result.camera_from_local;
  inquiry_.Ask(std::move(question));
}

void SingleAgent::UseAnswer() {
  const std::optional<PlaceAnswer> answer = inquiry_.TakeAnswer();
  if (!answer.has_value() || !Use(*answer)) return;
  absl::MutexLock lock(&mutex_);
  ++status_.places_told;
}

bool SingleAgent::Use(const PlaceAnswer& answer) {
  if (share_mode_ == ShareMode::kNone) return false;
  const PlaceQuestion& question = answer.question;
  if (question.local_map != current().map().local_map()) return false;
  if (question.camera_from_local.has_value()) {
    // One place says nothing about the scale of a map without metres.
    if (!camera_->IsMetric() && !options_.localise_only) return false;
    const Rigid3d global_from_local =
        answer.camera_from_global.Inverse() * *question.camera_from_local;
    absl::MutexLock lock(&mutex_);
    presumed_global_from_local_ = Similarity3d::FromRigid(global_from_local);
    return true;
  }
  const std::optional<Similarity3d> global_from_local = link_->GlobalFromLocal();
  if (!global_from_local.has_value()) return false;
  // The store is told this place, so that it shares what lies around it, though the map does not
  // show that yet.
  link_->AddLocalised({question.frame->timestamp_ns, answer.camera_from_global});
  const Similarity3d camera_from_local =
      Similarity3d::FromRigid(answer.camera_from_global) * *global_from_local;
  return current().tracker().ResumeAt(question.frame, camera_from_local.ToRigid());
}

void SingleAgent::Follow(const ChangedLimits& limits) {
  if (camera_->IsMetric()) {
    max_map_bytes_ = limits.max_map_bytes.value_or(max_map_bytes_);
    shedder_.SetMaxMapBytes(max_map_bytes_);
  } else if (limits.max_map_bytes.value_or(0) > 0) {
    SayFinding({FindingLevel::kWarning, "memory-budget-unused",
                "the memory budget that was ordered is not kept: the map of one camera alone "
                "can't go on in another one"});
  }
  if (limits.uplink_bytes_per_second) link_->SetUplinkRate(*limits.uplink_bytes_per_second);
  if (limits.share) {
    const ShareScope share = ShareOf(*limits.share, MayTakeOthers(options_, *camera_));
    share_mode_ = share.mode;
    link_->SetShare(share);
  }
}

void SingleAgent::FollowOrders() {
  if (options_.orders == nullptr) return;
  const OrdersForFrame orders = options_.orders->Take();
  // AgentOrders has judged the mask.
  if (orders.mask.has_value()) sensor_->SetMask(*orders.mask).IgnoreError();
  if (orders.open_local_map) BeginLocalMap();
  Follow(orders.limits);
  mapping_paused_ = orders.mapping_paused;
  current().tracker().PauseMapping(mapping_paused_);
}

void SingleAgent::BeginLocalMap() {
  if (resuming_.has_value()) NoteNotResumed("no place in it was recognised in time");
  EndLocalMap();
  OpenLocalMap();
}

void SingleAgent::EndLocalMap() {
  after_work_.Post([this, session = current_session_] {
    session->Settle(absl::Now() + kLongestEnd);
    session->Stop();
    link_->EndLocalMap(session->map().local_map());
  });
}

void SingleAgent::Watch(const Features& features) {
  for (std::optional<SourceFinding> finding :
       {input_watch_.Add(features), input_watch_.AddRows(sensor_->row_correction_px())}) {
    if (finding.has_value()) SayFinding(*std::move(finding));
  }
}

void SingleAgent::SayFinding(SourceFinding finding) {
  // A robot whose camera never ends has no report in which it could stand.
  LOG(WARNING) << options_.name << ": " << finding.text << " [" << finding.code << "]";
  absl::MutexLock lock(&mutex_);
  status_.input_findings.push_back(std::move(finding));
}

void SingleAgent::LeaveOutContradicting() {
  for (const MapContradiction& found : current().tracker().TakeContradictions()) {
    link_->LeaveOut(found);
    SayFinding(DescribeContradiction(found));
  }
}

void SingleAgent::Record(const TrackingResult& result, double tracking_ms, bool is_placed) {
  const bool tracked = result.state == TrackingState::kTracking;
  const size_t foreign_keyframes = link_->shared_keyframes();
  const absl::Time now = absl::Now();
  tracking_ms_.Add(tracking_ms);
  {
    absl::MutexLock lock(&mutex_);
    status_.state = result.state;
    status_.why_no_pose = result.why_no_pose;
    if (is_placed) presumed_global_from_local_.reset();
    ++status_.frames;
    ++(tracked ? status_.tracked : status_.lost);
    first_frame_ = std::min(first_frame_, now);
    const bool is_located = tracked && (is_placed || presumed_global_from_local_.has_value());
    if (is_located && !status_.located_after_s.has_value()) {
      status_.located_after_s = absl::ToDoubleSeconds(now - first_frame_);
    }
    if (tracked) RecordPose(result);
    if (tracked && foreign_keyframes > 0) {
      points_matched_ += result.points_matched;
      foreign_points_matched_ += result.foreign_points_matched;
    }
  }
  if (tracked && options_.orders != nullptr) options_.orders->NoteTracked();
  if (tracked) {
    link_->AddTrackedFrame({result.timestamp_ns, result.reference, result.reference_from_camera});
  } else {
    link_->AddLostFrame(result.timestamp_ns);
  }
  // The frame of the local map is then the global one.
  LocalisedFrame localised{result.timestamp_ns, std::nullopt};
  if (tracked) localised.camera_from_global = result.camera_from_local;
  link_->AddLocalised(localised);
}

void SingleAgent::RecordPose(const TrackingResult& result) {
  has_pose_ = true;
  status_.timestamp_ns = result.timestamp_ns;
  status_.local_from_camera = result.camera_from_local.Inverse();
  if (!options_.keep_trajectory) return;
  // Where the reference is another's keyframe, the frame is in no local map's trajectory.
  if (current().map().IsOwn(result.reference)) {
    tracked_frames_.push_back(
        {result.timestamp_ns, result.reference, result.reference_from_camera});
  }
  if (options_.localise_only) {
    finished_.trajectory.push_back(
        {result.timestamp_ns, result.local_map, status_.local_from_camera});
  }
}

void SingleAgent::Step() {
  if (!options_.deterministic) return;
  current().Step();
  link_->Step();
  if (far_ != nullptr) far_->Step();
  // Works off what came back while sending.
  current().Step();
}

absl::Status SingleAgent::Finish(absl::Duration timeout) {
  RETURN_IF_ERROR(UsePause());
  const absl::Time deadline = absl::Now() + timeout;
  if (!current().Settle(deadline)) {
    return absl::DeadlineExceededError("mapping and loop closing have not come to an end yet");
  }
  if (!after_work_.WaitUntilIdle(deadline)) {
    return absl::DeadlineExceededError("an earlier local map has not come to an end yet");
  }
  if (pictures_ != nullptr) pictures_->Finish();
  return link_->Finish(deadline - absl::Now());
}

std::optional<Similarity3d> SingleAgent::GlobalFromLocal(uint64_t corrections) const {
  if (const auto told = link_->GlobalFromLocal(corrections)) return told;
  absl::MutexLock lock(&mutex_);
  return presumed_global_from_local_;
}

AgentTimings SingleAgent::GetTimings() const { return {tracking_ms_.Copy(), local_ba_ms_.Copy()}; }

AgentStatus SingleAgent::GetStatus() const {
  AgentStatus status;
  Sessions sessions;
  {
    absl::MutexLock lock(&mutex_);
    status = status_;
    sessions = sessions_;
    status.keyframes = finished_.items.keyframes;
    status.map_points = finished_.items.points;
    status.loops_closed = finished_.loops.closed;
    status.foreign_loops_closed = finished_.loops.closed_against_others;
    if (points_matched_ > 0) {
      status.foreign_points_percent = 100.0 * static_cast<double>(foreign_points_matched_) /
                                      static_cast<double>(points_matched_);
    }
  }
  for (const auto& session : sessions) {
    const OwnItems items = session->map().own_items();
    status.keyframes += items.keyframes;
    status.map_points += items.points;
    const LoopCloserCounts loops = session->loop_closer().counts();
    status.loops_closed += loops.closed;
    status.foreign_loops_closed += loops.closed_against_others;
  }
  status.mapping_paused = options_.orders != nullptr && options_.orders->mapping_paused();
  status.global_from_local = GlobalFromLocal();
  status.without_metres = !HasMetres();
  status.global_without_metres = !GlobalHasMetres();
  status.map_bytes = sessions.back()->map_bytes();
  status.foreign_keyframes = static_cast<int>(link_->shared_keyframes());
  status.shared_updates = link_->shared_updates();
  status.upload = link_->upload();
  if (far_ != nullptr) status.far = far_->status();
  if (const auto first = link_->first_acknowledged()) {
    status.first_upload_s = absl::ToDoubleSeconds(*first - created_);
  }
  return status;
}

std::vector<TrajectoryPose> SingleAgent::LocalTrajectory() const {
  std::vector<TrackedFrame> frames;
  std::vector<TrajectoryPose> trajectory;
  Sessions sessions;
  {
    absl::MutexLock lock(&mutex_);
    frames = tracked_frames_;
    trajectory = finished_.trajectory;
    sessions = sessions_;
  }
  for (const auto& session : sessions) AppendTrajectory(frames, session->map(), trajectory);
  return trajectory;
}

std::optional<NearMap> SingleAgent::GetNearMap(const NearMapLimits& limits) const {
  std::shared_ptr<const LocalMapSession> session;
  Eigen::Vector3d centre;
  int64_t timestamp_ns = 0;
  {
    absl::MutexLock lock(&mutex_);
    if (!has_pose_) return std::nullopt;
    session = sessions_.back();
    centre = status_.local_from_camera.translation;
    timestamp_ns = status_.timestamp_ns;
  }
  NearMap near = FindNearMap(session->map(), centre, limits);
  near.timestamp_ns = timestamp_ns;
  return near;
}

Map SingleAgent::CopyMap() const {
  std::shared_ptr<const LocalMapSession> session;
  {
    absl::MutexLock lock(&mutex_);
    session = sessions_.back();
  }
  return session->map().Read([](const Map& map) { return map; });
}

}  // namespace corbslam::client_agent

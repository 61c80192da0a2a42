#include "client_agent/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "client_agent/tracking/frame_evidence.h"
#include "client_agent/tracking/frame_measurements.h"

namespace corbslam::client_agent {

Tracker::Tracker(const TrackerOptions& options, std::shared_ptr<const Camera> camera,
                 const TrackerParts& parts)
    : options_(options),
      camera_(std::move(camera)),
      parts_(parts),
      mapping_paused_(options.localise_only),
      monocular_start_(options.seed) {}

TrackingResult Tracker::Track(KeyframePayload seen) {
  seen.camera = camera_;
  Frame frame = MakeFrame(std::move(seen));
  CheckExpected(frame.payload->timestamp_ns);
  if (last_payload_ != nullptr) {
    rhythm_.Add(frame.payload->timestamp_ns - last_payload_->timestamp_ns);
  }
  last_payload_ = frame.payload;
  if (state_ == TrackingState::kNotInitialised && !options_.localise_only) {
    const WhyNoPose why_not = Begin(frame);
    return Conclude(std::move(frame), why_not);
  }
  const bool tracked = FindPose(frame);
  followed_ = 0;
  wants_features_ = false;
  if (tracked) {
    velocity_ = state_ == TrackingState::kTracking ? MotionTo(frame) : std::nullopt;
    ConsiderKeyframe(frame);
  }
  const WhyNoPose picture = tracked ? WhyNoPose::kHasOne : JudgePicture(frame);
  const bool unrecognised = !tracked && picture == WhyNoPose::kHasOne;
  unrecognised_in_a_row_ = unrecognised ? unrecognised_in_a_row_ + 1 : 0;
  if (unrecognised && Bridge(frame)) return Conclude(std::move(frame), WhyNoPose::kHasOne);
  const WhyNoPose unknown =
      was_anothers_camera_ ? WhyNoPose::kAnotherCamera : WhyNoPose::kNotRecognised;
  return Conclude(std::move(frame), unrecognised ? unknown : picture);
}

std::optional<HandedFrame> Tracker::HandOver() const {
  if (state_ != TrackingState::kTracking || mapping_paused_) return std::nullopt;
  if (!camera_->IsMetric()) return std::nullopt;
  if (JudgePicture(*previous_) != WhyNoPose::kHasOne) return std::nullopt;
  HandedFrame handed;
  handed.frame.payload = previous_->payload;
  handed.frame.words = previous_->words;
  handed.frame.camera_from_map = previous_->camera_from_map;
  handed.frame.associations.resize(previous_->associations.size());
  handed.motion = velocity_;
  return handed;
}

bool Tracker::TakeOver(const HandedFrame& handed) {
  Frame frame = handed.frame;
  MakeKeyframe(frame);
  if (!frame.keyframe.IsValid()) return false;
  state_ = TrackingState::kTracking;
  velocity_ = handed.motion;
  previous_ = std::move(frame);
  return true;
}

void Tracker::BeginLost() {
  state_ = TrackingState::kLost;
  begins_lost_ = true;
}

bool Tracker::IsLostForGood() const {
  if (state_ != TrackingState::kLost || mapping_paused_ || IsWellReckoned()) return false;
  const bool is_elsewhere =
      why_lost_ == WhyNoPose::kNotRecognised || why_lost_ == WhyNoPose::kAnotherCamera;
  if (!is_elsewhere) return false;
  if (begins_lost_) return lost_at_start_ns_ > options_.max_lost_at_start_ns;
  return lost_frames_ > options_.max_lost_frames ||
         local_map_.map_keyframes < options_.min_keyframes_to_wait;
}

WhyNoPose Tracker::Begin(Frame& frame) {
  if (mapping_paused_) return WhyNoPose::kMappingPaused;
  if (const WhyNoPose picture = JudgePicture(frame); picture != WhyNoPose::kHasOne) return picture;
  if (!parts_.queue->HasRoom()) return WhyNoPose::kMappingBusy;
  if (!camera_->IsMetric()) return BeginByParallax(frame);
  MakeKeyframe(frame);
  return WhyNoPose::kHasOne;
}

WhyNoPose Tracker::BeginByParallax(Frame& frame) {
  std::optional<MonocularBeginning> found = monocular_start_.Add(frame);
  if (!found.has_value()) return WhyNoPose::kLittleParallax;
  auto beginning = std::make_shared<MapBeginning>();
  EnsureWords(found->first);
  KeyframePayload first = *found->first.payload;
  first.id = parts_.map->NewKeyframeId();
  beginning->first = std::make_shared<const KeyframePayload>(std::move(first));
  beginning->words = found->first.words;
  beginning->points = std::move(found->points);
  frame = std::move(found->second);
  frame.reference = beginning->first->id;
  frame.camera_from_reference = frame.camera_from_map;
  MakeKeyframe(frame, beginning);
  AddTemporaryPoints(frame);
  // The camera went on as it went all the time since the first of both frames.
  const int64_t since_ns = frame.payload->timestamp_ns - beginning->first->timestamp_ns;
  const double frames = rhythm_.FramesIn(since_ns);
  velocity_ = CameraMotion{GoOnFor(1 / frames, frame.camera_from_map),
                           static_cast<int64_t>(static_cast<double>(since_ns) / frames)};
  return WhyNoPose::kHasOne;
}

WhyNoPose Tracker::JudgePicture(const Frame& frame) const {
  const std::vector<Keypoint>& keypoints = frame.keypoints();
  if (static_cast<int>(keypoints.size()) < options_.min_keypoints_to_begin) {
    return WhyNoPose::kFewKeypoints;
  }
  if (!camera_->IsMetric()) return WhyNoPose::kHasOne;
  const auto with_depth = std::count_if(keypoints.begin(), keypoints.end(),
                                        [](const Keypoint& k) { return k.HasDepth(); });
  return with_depth < options_.min_keypoints_to_begin / 5 ? WhyNoPose::kFewDepths
                                                          : WhyNoPose::kHasOne;
}

bool Tracker::FindPose(Frame& frame) {
  std::optional<Solution> solution = SolveInOneMap(frame);
  was_anothers_camera_ = solution.has_value() && !IsOfThisCamera(*solution);
  if (!solution.has_value() || was_anothers_camera_) return false;
  if (state_ == TrackingState::kLost) WeighExpected(solution->frame);
  Accept(*std::move(solution), frame);
  return true;
}

void Tracker::Accept(Solution solution, Frame& frame) {
  const bool goes_on = state_ == TrackingState::kTracking;
  frames_since_relocalisation_ = goes_on ? frames_since_relocalisation_ + 1 : 0;
  Adopt(std::move(solution), frame);
  HoldAgainstOthers(frame);
}

void Tracker::Adopt(Solution solution, Frame& frame) {
  frame = std::move(solution.frame);
  local_map_ = std::move(solution.local_map);
  inliers_ = solution.inliers;
  points_in_view_ = static_cast<int>(solution.visible.size());
  corrections_ = solution.corrections;
  parts_.statistics->Count(solution.visible, SeenPoints(frame));
}

void Tracker::HoldAgainstOthers(const Frame& frame) {
  if (options_.localise_only || !options_.has_stereo) return;
  for (const MapContradiction& found : others_scale_.Add(frame, parts_.map->local_map())) {
    contradictions_.push_back(found);
  }
  if (const auto bent = others_shape_.Add(frame, parts_.map->local_map())) {
    contradictions_.push_back(*bent);
  }
}

bool Tracker::ResumeAt(std::shared_ptr<const KeyframePayload> payload,
                       const Rigid3d& camera_from_map) {
  const bool may_resume = state_ == TrackingState::kLost && payload != nullptr;
  if (!may_resume) return false;
  Solution solution;
  solution.corrections = parts_.map->corrections();
  solution.frame.payload = std::move(payload);
  if (!RelocaliseNear(*parts_.map, camera_from_map, solution.frame)) return false;
  if (!TrackLocalMap(solution) || !IsBelievable(solution)) return false;
  if (!IsOfThisCamera(solution)) return false;
  Frame frame;
  Accept(std::move(solution), frame);
  SetReference(frame);
  DropTemporaryPoints(frame);
  velocity_.reset();
  lost_frames_ = 0;
  begins_lost_ = false;
  state_ = TrackingState::kTracking;
  previous_ = std::move(frame);
  return true;
}

void Tracker::SetReference(Frame& frame) const {
  if (local_map_.reference.IsValid()) {
    frame.reference = local_map_.reference;
    frame.camera_from_reference = frame.camera_from_map * local_map_.reference_from_map.Inverse();
  } else if (previous_.has_value()) {
    frame.reference = previous_->reference;
    frame.camera_from_reference = frame.camera_from_map * previous_->camera_from_map.Inverse() *
                                  previous_->camera_from_reference;
  }
}

KeyframeEvidence Tracker::EvidenceOf(const LocalMapView& local_map, int inliers,
                                     int64_t timestamp_ns) const {
  KeyframeEvidence evidence;
  evidence.inliers = inliers;
  evidence.reference_points = local_map.reference_points;
  evidence.share_of_reference = local_map.share_of_reference;
  evidence.map_keyframes = local_map.map_keyframes;
  evidence.since_last_keyframe_s =
      std::abs(static_cast<double>(timestamp_ns - last_keyframe_ns_)) * 1e-9;
  evidence.mapper_idle = parts_.queue->IsIdle();
  evidence.queue_has_room = parts_.queue->HasRoom();
  return evidence;
}

void Tracker::ConsiderKeyframe(Frame& frame) {
  SetReference(frame);
  KeyframeEvidence evidence =
      EvidenceOf(local_map_, inliers_.map_points, frame.payload->timestamp_ns);
  CountClosePoints(frame, evidence);
  LearnGuess(evidence);
  // Until the last keyframe is in the map, its points can't be told from untracked ones.
  const bool last_is_in_map = local_map_.map_keyframes > 0 && parts_.queue->keyframes() == 0;
  if (!mapping_paused_ && last_is_in_map && ShouldMakeKeyframe(evidence, options_.keyframe))
    MakeKeyframe(frame);
}

void Tracker::MakeKeyframe(Frame& frame, std::shared_ptr<const MapBeginning> beginning) {
  EnsureWords(frame);
  const KeyframeId id = parts_.map->NewKeyframeId();
  NewKeyframe keyframe;
  KeyframePayload payload = *frame.payload;
  payload.id = id;
  keyframe.payload = std::make_shared<const KeyframePayload>(std::move(payload));
  keyframe.words = frame.words;
  keyframe.beginning = std::move(beginning);
  keyframe.reference = frame.reference;
  keyframe.camera_from_reference =
      frame.reference.IsValid() ? frame.camera_from_reference : frame.camera_from_map;
  keyframe.points.reserve(frame.associations.size());
  for (const Association& association : frame.associations) {
    keyframe.points.push_back(association.id);
  }
  if (!parts_.queue->PushKeyframe(std::move(keyframe))) return;
  frame.keyframe = id;
  frame.reference = id;
  frame.camera_from_reference = Rigid3d::Identity();
  last_keyframe_ = id;
  last_keyframe_ns_ = frame.payload->timestamp_ns;
}

void Tracker::EnsureWords(Frame& frame) const {
  if (frame.words != nullptr) return;
  frame.words = std::make_shared<const Words>(parts_.vocabulary->Transform(frame.descriptors()));
}

void Tracker::KeepMeasurements(const Frame& frame) const {
  if (parts_.measurements == nullptr || frame.keyframe.IsValid()) return;
  parts_.measurements->Add(parts_.map->Read(
      [&](const Map& map) { return FindMeasurements(map, parts_.map->local_map(), frame); }));
}

std::optional<CameraMotion> Tracker::MotionTo(const Frame& frame) const {
  if (!previous_.has_value()) return std::nullopt;
  return CameraMotion{frame.camera_from_map * previous_->camera_from_map.Inverse(),
                      frame.payload->timestamp_ns - previous_->payload->timestamp_ns};
}

TrackingResult Tracker::Conclude(Frame frame, WhyNoPose why_no_pose) {
  TrackingResult result;
  result.timestamp_ns = frame.payload->timestamp_ns;
  result.local_map = parts_.map->local_map();
  result.why_no_pose = why_no_pose;
  if (why_no_pose == WhyNoPose::kHasOne) {
    ConcludeTracked(std::move(frame), result);
  } else if (state_ != TrackingState::kNotInitialised || options_.localise_only) {
    first_lost_ns_ = first_lost_ns_.value_or(result.timestamp_ns);
    lost_at_start_ns_ = std::abs(result.timestamp_ns - *first_lost_ns_);
    result.reckoned = Reckon();
    ConcludeLost(why_no_pose);
  }
  result.state = state_;
  return result;
}

void Tracker::ConcludeLost(WhyNoPose why_no_pose) {
  state_ = TrackingState::kLost;
  velocity_.reset();
  why_lost_ = why_no_pose;
  const bool counts = why_no_pose == WhyNoPose::kNotRecognised ||
                      why_no_pose == WhyNoPose::kAnotherCamera ||
                      lost_frames_ < options_.max_lost_frames / 2;
  lost_frames_ += counts ? 1 : 0;
}

void Tracker::ConcludeTracked(Frame frame, TrackingResult& result) {
  // An own map is bent to its robot's camera; in others' map another camera is elsewhere.
  result.was_bridged = frame.keyframe.IsValid() && frame.keyframe == bridge_;
  if (result.was_bridged) {
    result.covariance = Reckon()->covariance;
  } else {
    result.covariance =
        options_.localise_only ? AnyCamerasCovariance(frame) : FramePoseCovariance(frame);
  }
  previous_covariance_ = result.covariance;
  result.motion = MotionTo(frame);
  const bool waits_for_points = !camera_->IsMetric() && local_map_.map_keyframes == 0;
  if (waits_for_points) KeepFoundDepths(frame);
  DropTemporaryPoints(frame);
  // Its features measure better.
  if (!wants_features_) KeepMeasurements(frame);
  state_ = TrackingState::kTracking;
  begins_lost_ = false;
  lost_frames_ = 0;
  result.corrections = corrections_;
  result.camera_from_local = frame.camera_from_map;
  result.reference = frame.reference;
  result.reference_from_camera = frame.camera_from_reference.Inverse();
  result.points_matched = inliers_.map_points;
  result.foreign_points_matched = inliers_.foreign;
  result.points_in_view = points_in_view_;
  result.made_keyframe = frame.keyframe.IsValid();
  result.follows_keyframe = std::exchange(became_keyframe_, false);
  previous_ = std::move(frame);
}

}  // namespace corbslam::client_agent

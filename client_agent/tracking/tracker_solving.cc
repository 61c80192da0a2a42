// Implements the part of Tracker that finds the pose of a frame, and says how far it is believed.
#include <algorithm>
#include <utility>

#include "client_agent/tracking/frame_evidence.h"
#include "client_agent/tracking/frame_matching.h"
#include "client_agent/tracking/tracker.h"

namespace corbslam::client_agent {
namespace {

// With fewer matches in the first radius, the search goes on in twice that (ORB-SLAM, T-RO 2015,
// V.B).
constexpr int kMinPreviousMatches = 20;
constexpr int kMinKeyframeMatches = 15;
constexpr int kMinFirstInliers = 10;
// Attempts at one frame. Corrections are seconds apart.
constexpr int kMaxAttempts = 3;

}  // namespace

// A map that is corrected meanwhile would leave points from before beside a reference from after.
std::optional<Tracker::Solution> Tracker::SolveInOneMap(const Frame& frame) {
  std::optional<Solution> solution;
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    const uint64_t corrections = parts_.map->corrections();
    parts_.map->ReadWithHistory([&](const Map& map, const MapHistory& history) {
      if (previous_.has_value()) Refresh(map, history, *previous_);
    });
    if (state_ != TrackingState::kTracking) {
      solution = Solve({&Tracker::ComeBackAsExpected, &Tracker::Relocalise}, frame, std::nullopt);
    } else {
      // If the previous frame has just become a keyframe, mapping may not have made its points yet.
      AddTemporaryPoints(*previous_);
      solution = SolveTracking(frame);
    }
    if (solution.has_value()) solution->corrections = corrections;
    if (parts_.map->corrections() == corrections) break;
  }
  return solution;
}

std::optional<Tracker::Solution> Tracker::SolveTracking(const Frame& frame) {
  std::optional<Solution> best = Solve({&Tracker::FollowExpected}, frame, std::nullopt);
  if (best.has_value() && IsSure(*best)) return best;
  const bool has_gap = velocity_.has_value() && TimesOfMotion(frame.payload->timestamp_ns) != 1;
  best = Solve({&Tracker::FollowMotion}, frame, std::move(best));
  // Frames were dropped, or the stamps are not when pictures were taken: what looks alike may agree
  // on a pose wherever it is sought, so that both are tried.
  if (has_gap) {
    best = Choose(Solve({&Tracker::FollowMotionInTime}, frame, std::nullopt), std::move(best));
  }
  if (best.has_value() && IsSure(*best)) return best;
  return Solve(
      {&Tracker::SearchAroundPrevious, &Tracker::MatchReferenceKeyframe, &Tracker::Relocalise},
      frame, std::move(best));
}

// Tries the ways in turn until one leads to a pose beyond doubt; else the best supported, which may
// be the one that there was before.
std::optional<Tracker::Solution> Tracker::Solve(const std::vector<FirstPose>& ways,
                                                const Frame& frame,
                                                std::optional<Solution> best) const {
  for (const FirstPose way : ways) {
    Solution solution;
    solution.frame = frame;
    if (best.has_value()) solution.frame.words = best->frame.words;
    if (!(this->*way)(solution.frame) || !TrackLocalMap(solution)) continue;
    if (!IsBelievable(solution)) continue;
    const bool is_sure = IsSure(solution);
    if (!best.has_value() || Support(solution) > Support(*best)) best = std::move(solution);
    if (is_sure) break;
  }
  return best;
}

// The pictures tell: at the right place more points agree, and a larger share of those in view.
// Where they don't tell clearly, it is as it was lately.
std::optional<Tracker::Solution> Tracker::Choose(std::optional<Solution> in_time,
                                                 std::optional<Solution> as_before) {
  constexpr double kClearly = 1.3;
  constexpr int kMostTrust = 5;
  const double now = in_time.has_value() ? Evidence(*in_time) : 0;
  const double before = as_before.has_value() ? Evidence(*as_before) : 0;
  if (now > kClearly * before) {
    trust_in_stamps_ = std::min(trust_in_stamps_ + 1, kMostTrust);
    return in_time;
  }
  if (before > kClearly * now) {
    trust_in_stamps_ = std::max(trust_in_stamps_ - 1, -kMostTrust);
    return as_before;
  }
  return trust_in_stamps_ >= 0 ? in_time : as_before;
}

int Tracker::Support(const Solution& solution) {
  const bool has_points = solution.local_map.map_keyframes > 0 && !solution.waits_for_bridge;
  return has_points ? solution.inliers.map_points : solution.inliers.total();
}

bool Tracker::IsDoubtful(const Solution& solution) const {
  return Support(solution) < options_.doubtful_share * static_cast<double>(solution.visible.size());
}

// Without a known motion far points alone may agree on a wrong position.
bool Tracker::IsSure(const Solution& solution) const {
  return (velocity_.has_value() || expected_.has_value()) && !IsDoubtful(solution);
}

double Tracker::Evidence(const Solution& solution) {
  const double points = Support(solution);
  return points * points / std::max<double>(1, static_cast<double>(solution.visible.size()));
}

bool Tracker::IsInOthers(const Solution& solution) const {
  return options_.localise_only || 2 * solution.inliers.foreign > solution.inliers.map_points;
}

bool Tracker::IsSupportedInOthers(const Solution& solution) const {
  // More than that chance does not find.
  constexpr int kBeyondChance = 200;
  if (!options_.localise_only || Support(solution) >= kBeyondChance) return true;
  return Support(solution) >=
         FrameEvidence(solution.frame, solution.local_map.points).InliersNeeded();
}

bool Tracker::IsOfThisCamera(const Solution& solution) {
  if (!IsInOthers(solution)) return true;
  const std::vector<PointInView>& points = solution.local_map.points;
  if (state_ != TrackingState::kTracking) {
    return camera_doubt_.BelievesFound(solution.frame, points);
  }
  return !options_.localise_only || camera_doubt_.BelievesTracked(solution.frame, points);
}

bool Tracker::IsBelievable(const Solution& solution) const {
  if (!IsSupportedInOthers(solution) || !IsWithinReach(solution)) return false;
  if (!IsDoubtful(solution)) return true;
  const double least = options_.min_doubtful_share * static_cast<double>(solution.visible.size());
  return Support(solution) >= options_.min_local_map_inliers_after_relocalisation &&
         Support(solution) >= least;
}

bool Tracker::FollowMotion(Frame& frame) const {
  if (!velocity_.has_value()) return false;
  return TrackPreviousFrame(velocity_->camera_from_previous * previous_->camera_from_map,
                            options_.previous_frame_radius_px, frame);
}

double Tracker::TimesOfMotion(int64_t timestamp_ns) const {
  const int now = rhythm_.FramesIn(timestamp_ns - previous_->payload->timestamp_ns);
  return static_cast<double>(now) / rhythm_.FramesIn(velocity_->since_ns);
}

bool Tracker::FollowMotionInTime(Frame& frame) const {
  const Rigid3d motion =
      GoOnFor(TimesOfMotion(frame.payload->timestamp_ns), velocity_->camera_from_previous);
  return TrackPreviousFrame(motion * previous_->camera_from_map, options_.previous_frame_radius_px,
                            frame);
}

bool Tracker::SearchAroundPrevious(Frame& frame) const {
  return TrackPreviousFrame(previous_->camera_from_map, 3 * options_.previous_frame_radius_px,
                            frame);
}

bool Tracker::TrackPreviousFrame(const Rigid3d& predicted, double radius_px, Frame& frame) const {
  int matches = MatchPreviousFrame(*previous_, predicted, radius_px, frame);
  if (matches < kMinPreviousMatches) {
    matches = MatchPreviousFrame(*previous_, predicted, 2 * radius_px, frame);
  }
  if (matches < kMinPreviousMatches) return false;
  const InlierCount inliers = OptimiseFramePose(predicted, parts_.map->local_map(), frame);
  return inliers.map_points >= kMinFirstInliers || inliers.total() >= kMinPreviousMatches;
}

bool Tracker::MatchReferenceKeyframe(Frame& frame) const {
  EnsureWords(frame);
  const int matches = parts_.map->Read([&](const Map& map) {
    const Keyframe* reference = map.FindKeyframe(previous_->reference);
    return reference == nullptr ? 0 : MatchKeyframe(map, *reference, frame);
  });
  if (matches < kMinKeyframeMatches) return false;
  const InlierCount inliers =
      OptimiseFramePose(previous_->camera_from_map, parts_.map->local_map(), frame);
  return inliers.map_points >= kMinFirstInliers;
}

bool Tracker::Relocalise(Frame& frame) const {
  if (parts_.places == nullptr) return false;
  EnsureWords(frame);
  return RelocaliseFrame(*parts_.map, *parts_.places, options_.seed, frame);
}

bool Tracker::TrackLocalMap(Solution& solution) const {
  const LocalMapId own = parts_.map->local_map();
  Frame& frame = solution.frame;
  const std::vector<MapPointId> seen = SeenPoints(frame);
  solution.local_map = parts_.map->Read([&](const Map& map) {
    LocalMapView view =
        GatherLocalMap(map, own, seen, previous_.has_value() ? previous_->reference : KeyframeId(),
                       frame.camera(), frame.camera_from_map);
    if (options_.localise_only) ReferToOthers(map, seen, view);
    solution.waits_for_bridge = bridge_.IsValid() && map.FindKeyframe(bridge_) == nullptr;
    return view;
  });
  // What is true is what others mapped: temporary points, at the previous pose's errors, would hold
  // the next one to these.
  if (options_.localise_only) DropTemporaryPoints(frame);
  const bool is_lost = state_ != TrackingState::kTracking;
  const bool is_fresh = is_lost || frames_since_relocalisation_ < 2;
  const bool on_probation = is_lost || frames_since_relocalisation_ < kProbation;
  MatchLocalPoints(solution.local_map.points, is_fresh ? 5 : options_.local_map_widening, frame,
                   solution.visible);
  solution.inliers = OptimiseFramePose(frame.camera_from_map, own, frame);
  const int least = on_probation ? options_.min_local_map_inliers_after_relocalisation
                                 : options_.min_local_map_inliers;
  return Support(solution) >= least;
}

}  // namespace corbslam::client_agent

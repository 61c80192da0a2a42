// Implements the part of Tracker that follows patches of keyframes' pictures from frame to frame.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/types/span.h"
#include "client_agent/tracking/frame_matching.h"
#include "client_agent/tracking/tracker.h"
#include "slam/sensor/patch_search.h"
#include "slam/sensor/picture_shift.h"

namespace corbslam::client_agent {
namespace {

// Patches that are sought first, from further away, for a first pose; and in all.
constexpr size_t kFirstPatches = 100;
constexpr size_t kMostPatches = 600;
constexpr int kLeastFirst = 25;
// A pose that patches give rests on so many, and on this share of those sought.
constexpr int kLeastInliers = 60;
constexpr double kLeastShare = 0.2;
// Between frames that are further apart more has changed, and there is time to search them.
constexpr int64_t kLongestApart_ns = 150'000'000;
// How far from a patch its feature is sought.
constexpr double kNear_px = 3;
// What a guess is taken for, so that hardly one is too high.
constexpr double kCautious = 0.9;
// Weight of the newest frame in how good guesses are.
constexpr double kNewestShare = 0.3;

// The levels that FindPictureShift reads, which are copies already.
HalvedPicture SmallOf(const HalvedPicture& picture) {
  HalvedPicture small;
  for (size_t i = PatchSearch::kLevels; i < small.levels.size(); ++i) {
    small.levels[i] = picture.levels[i];
  }
  return small;
}

// Returns the pose of a camera that turned on the spot.
Rigid3d AsTurned(const PictureShift& shift, const Camera& camera, const Rigid3d& before_from_map) {
  Rigid3d now_from_before;
  now_from_before.rotation = ExpSO3(
      {-shift.shift_px.y() / camera.fy_px, shift.shift_px.x() / camera.fx_px, shift.turn_rad});
  return now_from_before * before_from_map;
}

}  // namespace

bool Tracker::MayFollow(int64_t timestamp_ns) const {
  if (state_ != TrackingState::kTracking || !velocity_.has_value()) return false;
  if (options_.localise_only || frames_since_relocalisation_ < kProbation) return false;
  if (timestamp_ns - previous_->payload->timestamp_ns > kLongestApart_ns) return false;
  const bool is_expected = expected_.has_value() || TimesOfMotion(timestamp_ns) == 1;
  return followed_ < options_.most_followed && is_expected;
}

std::optional<TrackingResult> Tracker::Follow(const FreshPicture& fresh) {
  guessed_inliers_.reset();
  CheckExpected(fresh.images->timestamp_ns);
  const LocalMapId own = parts_.map->local_map();
  Solution solution;
  solution.corrections = parts_.map->corrections();
  std::vector<PatchSource> sources;
  Rigid3d predicted;
  parts_.map->ReadWithHistory([&](const Map& map, const MapHistory& history) {
    Refresh(map, history, *previous_);
    const Rigid3d& motion =
        expected_.has_value() ? expected_->camera_from_previous : velocity_->camera_from_previous;
    predicted = motion * previous_->camera_from_map;
    solution.local_map =
        GatherLocalMap(map, own, SeenPoints(*previous_), previous_->reference, *camera_, predicted);
    sources =
        FindPatchSources(map, own, solution.local_map.points, *camera_, pictures_, kMostPatches);
  });
  const std::optional<Rigid3d> roughly = FindRoughly(fresh, predicted, sources);
  if (!roughly.has_value()) return std::nullopt;
  solution.frame = FollowPatches(fresh, camera_, *roughly, sources, 0);
  solution.inliers = OptimiseFramePose(*roughly, own, solution.frame);
  const double least = kLeastShare * static_cast<double>(sources.size());
  if (solution.inliers.map_points < kLeastInliers || solution.inliers.map_points < least) {
    return std::nullopt;
  }
  if (parts_.map->corrections() != solution.corrections) return std::nullopt;
  KeyframeEvidence guess = Guess(solution, sources.size());
  guessed_inliers_ = guess.inliers;
  // A guess that is too high would leave a keyframe out.
  guess.inliers = static_cast<int>(kCautious * guess.inliers);
  wants_features_ = ++followed_ >= options_.most_followed ||
                    (!mapping_paused_ && ShouldMakeKeyframe(guess, options_.keyframe));
  for (const PatchSource& source : sources) solution.visible.push_back(source.point);
  return Take(std::move(solution));
}

// Tries the motion as before, then what the picture as a whole says that the camera turned.
std::optional<Rigid3d> Tracker::FindRoughly(const FreshPicture& fresh, const Rigid3d& predicted,
                                            const std::vector<PatchSource>& sources) {
  const HalvedPicture before = std::exchange(last_picture_, SmallOf(fresh.picture));
  const auto first = absl::MakeConstSpan(sources).first(std::min(sources.size(), kFirstPatches));
  const auto follow = [&](const Rigid3d& from) -> std::optional<Rigid3d> {
    Frame roughly = FollowPatches(fresh, camera_, from, first, PatchSearch::kLevels - 1);
    const InlierCount inliers = OptimiseFramePose(from, parts_.map->local_map(), roughly);
    if (inliers.map_points < kLeastFirst) return std::nullopt;
    return roughly.camera_from_map;
  };
  if (const auto roughly = follow(predicted)) return roughly;
  const std::optional<PictureShift> shift = FindPictureShift(before, fresh.picture);
  if (!shift.has_value()) return std::nullopt;
  return follow(AsTurned(*shift, *camera_, previous_->camera_from_map));
}

TrackingResult Tracker::Take(Solution solution) {
  ++frames_since_relocalisation_;
  Frame frame;
  Adopt(std::move(solution), frame);
  if (last_payload_ != nullptr) {
    rhythm_.Add(frame.payload->timestamp_ns - last_payload_->timestamp_ns);
  }
  last_payload_ = frame.payload;
  velocity_ = MotionTo(frame);
  SetReference(frame);
  TrackingResult result = Conclude(std::move(frame), WhyNoPose::kHasOne);
  result.was_followed = true;
  return result;
}

KeyframeId Tracker::Describe(KeyframePayload seen) {
  wants_features_ = false;
  followed_ = 0;
  if (state_ != TrackingState::kTracking) return {};
  if (previous_->payload->timestamp_ns != seen.timestamp_ns) return {};
  seen.camera = camera_;
  Solution solution;
  solution.corrections = parts_.map->corrections();
  solution.frame = MakeFrame(std::move(seen));
  parts_.map->ReadWithHistory(
      [&](const Map& map, const MapHistory& history) { Refresh(map, history, *previous_); });
  MatchPreviousFrame(*previous_, previous_->camera_from_map, kNear_px, solution.frame);
  solution.frame.camera_from_map = previous_->camera_from_map;
  if (!TrackLocalMap(solution) || !IsBelievable(solution)) return {};
  if (parts_.map->corrections() != solution.corrections) return {};
  Frame frame;
  Adopt(std::move(solution), frame);
  HoldAgainstOthers(frame);
  ConsiderKeyframe(frame);
  KeepMeasurements(frame);
  const KeyframeId keyframe = frame.keyframe;
  became_keyframe_ = keyframe.IsValid();
  last_payload_ = frame.payload;
  previous_ = std::move(frame);
  return keyframe;
}

// Features are found of the same share of what is in view as in the frame before that was searched
// for them.
KeyframeEvidence Tracker::Guess(const Solution& followed, size_t sought) const {
  constexpr double kUsualShare = 0.8;
  const double share_found = static_cast<double>(followed.inliers.map_points) /
                             static_cast<double>(std::max<size_t>(1, sought));
  const double in_view = static_cast<double>(followed.local_map.points.size());
  const double as_described =
      static_cast<double>(described_.inliers) / std::max(1, described_in_view_);
  const double inliers =
      guess_factor_ * as_described * in_view * std::min(1.0, share_found / kUsualShare);
  KeyframeEvidence guess = EvidenceOf(followed.local_map, static_cast<int>(inliers),
                                      followed.frame.payload->timestamp_ns);
  guess.share_of_reference = described_.share_of_reference;
  guess.close_untracked = described_.close_untracked;
  const double of_described = static_cast<double>(guess.inliers) / std::max(1, described_.inliers);
  guess.close_tracked = static_cast<int>(of_described * described_.close_tracked);
  return guess;
}

void Tracker::LearnGuess(const KeyframeEvidence& evidence) {
  if (guessed_inliers_.has_value() && *guessed_inliers_ > 0) {
    const double was = std::clamp(evidence.inliers / *guessed_inliers_, 0.5, 2.0);
    guess_factor_ *= 1 + kNewestShare * (was - 1);
    guess_factor_ = std::clamp(guess_factor_, 0.5, 2.0);
  }
  guessed_inliers_.reset();
  described_ = evidence;
  described_in_view_ = points_in_view_;
}

}  // namespace corbslam::client_agent

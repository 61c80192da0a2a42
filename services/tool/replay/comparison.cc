#include "services/tool/replay/comparison.h"

#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "services/programs/recording/recorded_lines.h"

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

// Follows the results of one run: what changes, and where the local map in use began.
class Run {
 public:
  void Add(size_t frame, const TrackingResult& result) {
    if (result.local_map != local_map_) {
      ++local_maps_;
      began_ = frame;
    }
    if (result.local_map != local_map_ || result.state != state_) {
      events_.push_back({frame, absl::StrCat(WordOf(result.state), " in local map ", local_maps_)});
    }
    local_map_ = result.local_map;
    state_ = result.state;
  }
  size_t began() const { return began_; }
  std::vector<TrackingEvent> events() && { return std::move(events_); }

 private:
  std::optional<LocalMapId> local_map_;
  std::optional<TrackingState> state_;
  size_t local_maps_ = 0;
  size_t began_ = 0;
  std::vector<TrackingEvent> events_;
};

PoseDifference DifferenceOf(size_t frame, const TrackingResult& a, const TrackingResult& b) {
  const Eigen::Vector3d apart =
      CameraCentre(a.camera_from_local) - CameraCentre(b.camera_from_local);
  const double angle_rad =
      RotationAngle(a.camera_from_local.rotation * b.camera_from_local.rotation.conjugate());
  return {frame, apart.norm(), angle_rad * 180 / std::numbers::pi};
}

void ComparePoses(const PoseDifference& difference, ReplayComparison& comparison) {
  if (!comparison.first_pose.has_value()) comparison.first_pose = difference;
  if (!comparison.largest_pose.has_value() ||
      difference.position_m > comparison.largest_pose->position_m) {
    comparison.largest_pose = difference;
  }
}

std::string FormatEvents(const std::vector<TrackingEvent>& events) {
  return absl::StrJoin(events, ", ", [](std::string* out, const TrackingEvent& event) {
    absl::StrAppend(out, "frame ", event.frame, " ", event.what);
  });
}

std::string FormatPose(const char* which, const PoseDifference& difference) {
  return absl::StrFormat("%s pose that differs: frame %d, by %.3g m and %.3g degrees\n", which,
                         difference.frame, difference.position_m, difference.angle_deg);
}

}  // namespace

ReplayComparison CompareResults(const FrameResults& recorded, const FrameResults& replayed) {
  ReplayComparison comparison;
  Run recorded_run;
  Run replayed_run;
  for (size_t i = 0; i < recorded.size(); ++i) {
    if (recorded[i].has_value()) recorded_run.Add(i, *recorded[i]);
    if (replayed[i].has_value()) replayed_run.Add(i, *replayed[i]);
    if (!recorded[i].has_value() || !replayed[i].has_value()) continue;
    ++comparison.compared;
    if (AreEqual(*recorded[i], *replayed[i])) {
      ++comparison.equal;
      continue;
    }
    if (!comparison.first_different.has_value()) comparison.first_different = i;
    const bool both_track = recorded[i]->state == TrackingState::kTracking &&
                            replayed[i]->state == TrackingState::kTracking;
    if (!both_track || recorded_run.began() != replayed_run.began()) continue;
    ComparePoses(DifferenceOf(i, *recorded[i], *replayed[i]), comparison);
  }
  comparison.recorded_events = std::move(recorded_run).events();
  comparison.replayed_events = std::move(replayed_run).events();
  return comparison;
}

uint64_t DigestOf(const FrameResults& results) {
  uint64_t hash = 14695981039346656037ull;
  for (size_t i = 0; i < results.size(); ++i) {
    if (!results[i].has_value()) continue;
    TrackingResult result;
    result.timestamp_ns = results[i]->timestamp_ns;
    result.state = results[i]->state;
    result.local_map = results[i]->local_map;
    // The rest is valid while tracking only.
    if (result.state == TrackingState::kTracking) result = *results[i];
    for (const char c : FormatLine(ResultLine{i, 0, result})) {
      hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
    }
  }
  return hash;
}

std::string FormatComparison(const ReplayComparison& comparison) {
  std::string text = absl::StrCat(comparison.equal, " of ", comparison.compared,
                                  " frames are equal to the digit to what was recorded\n");
  if (comparison.first_different.has_value()) {
    absl::StrAppend(&text, "the first that differs: frame ", *comparison.first_different, "\n");
  }
  if (comparison.first_pose.has_value()) {
    absl::StrAppend(&text, FormatPose("the first", *comparison.first_pose),
                    FormatPose("the largest difference of a", *comparison.largest_pose));
  }
  absl::StrAppend(&text, "recorded: ", FormatEvents(comparison.recorded_events), "\n");
  if (comparison.recorded_events == comparison.replayed_events) {
    return text + "replayed: the same\n";
  }
  return absl::StrCat(text, "replayed: ", FormatEvents(comparison.replayed_events), "\n");
}

}  // namespace corbslam::services

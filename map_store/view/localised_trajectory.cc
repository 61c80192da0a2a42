#include "map_store/view/localised_trajectory.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

// A run's frames and lost times, sorted.
struct SortedRun {
  explicit SortedRun(const LocalisedRun& run) : frames(run.frames), lost_ns(run.lost_frames_ns) {
    std::ranges::stable_sort(frames, {}, &TrackedFrame::timestamp_ns);
    std::ranges::sort(lost_ns);
  }
  bool IsLostBetween(int64_t begin_ns, int64_t end_ns) const {
    const auto it = std::ranges::upper_bound(lost_ns, begin_ns);
    return it != lost_ns.end() && *it < end_ns;
  }
  std::vector<TrackedFrame> frames;
  std::vector<int64_t> lost_ns;
};

// `trajectory` has room for all frames.
void AppendRun(const MissionState& state, const LocalisedRun& run, bool all_islands,
               const std::optional<Rigid3d>& camera_from_wanted, AgentTrajectory& trajectory) {
  const SortedRun sorted(run);
  trajectory.lost += run.lost_frames_ns.size();
  bool gap = !trajectory.poses.empty();
  const StoredPose* before = nullptr;
  for (const TrackedFrame& frame : sorted.frames) {
    const std::optional<PlaceInIsland> place = PlaceLocalised(state, frame);
    if (!place.has_value() || (!all_islands && place->island != state.ReferenceIsland())) {
      ++trajectory.left_out;
      gap = true;
      continue;
    }
    gap = gap ||
          (before != nullptr && (before->island != place->island ||
                                 sorted.IsLostBetween(before->timestamp_ns, frame.timestamp_ns)));
    StoredPose& pose = trajectory.poses.emplace_back();
    pose.timestamp_ns = frame.timestamp_ns;
    pose.frame_from_camera = place->island_from_camera;
    if (camera_from_wanted.has_value()) {
      pose.frame_from_camera = pose.frame_from_camera * *camera_from_wanted;
    }
    pose.island = place->island;
    pose.after_gap = gap;
    pose.run = run.id;
    before = &pose;
    gap = false;
  }
}

}  // namespace

std::optional<PlaceInIsland> PlaceLocalised(const MissionState& state, const TrackedFrame& frame) {
  LivingRelative relative;
  if (!FindLivingRelative(state, frame.reference, relative)) return std::nullopt;
  const LocalMapId of_relative = relative.id.local_map;
  const auto table = FindPoses(state, *state.FindLocalMap(of_relative));
  const Similarity3d& camera_from_island = table->poses.at(relative.id);
  // What chains keyframes is in the units of their owner, what the robot said in the island's.
  Rigid3d relative_from_reference = relative.relative_from_id;
  relative_from_reference.translation /= camera_from_island.scale;
  return PlaceInIsland{state.global.island_of.at(of_relative),
                       camera_from_island.ToRigid().Inverse() * relative_from_reference *
                           frame.reference_from_camera};
}

absl::Status AppendLocalised(const MissionState& state, const AgentState& agent, bool all_islands,
                             PosesOf poses_of, AgentTrajectory& trajectory) {
  trajectory.dropped = agent.track.dropped;
  // Once for all runs: each time takes a copy of all that is there.
  trajectory.poses.reserve(trajectory.poses.size() + CountFrames(agent.track));
  for (const LocalisedRun& run : agent.track.runs) {
    const auto camera_from_wanted = CameraFromWanted(run.recorded_camera, poses_of);
    if (!camera_from_wanted.ok()) {
      return absl::FailedPreconditionError(absl::StrCat("agent ", trajectory.agent, ", run ",
                                                        ToString(LocalMapId{run.id}), ": ",
                                                        camera_from_wanted.status().message()));
    }
    AppendRun(state, run, all_islands, *camera_from_wanted, trajectory);
  }
  return absl::OkStatus();
}

void LeaveOutLocalised(const AgentState& agent, AgentTrajectory& trajectory) {
  trajectory.dropped = agent.track.dropped;
  trajectory.left_out += CountFrames(agent.track);
  for (const LocalisedRun& run : agent.track.runs) trajectory.lost += run.lost_frames_ns.size();
}

}  // namespace corbslam::map_store

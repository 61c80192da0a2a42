#include "map_store/view/trajectory.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/state/session_frames.h"
#include "map_store/view/localised_trajectory.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

// Computes the poses of one local map's frames, in its island's frame or its own.
class FrameChain {
 public:
  // `camera_from_wanted` is nullopt if poses of the camera itself are wanted.
  FrameChain(const MissionState& state, const LocalMapState& local_map, TrajectoryFrame frame,
             const std::optional<Rigid3d>& camera_from_wanted)
      : state_(state),
        local_map_(local_map),
        frame_(frame),
        camera_from_wanted_(camera_from_wanted),
        poses_(state, all_placed_) {}

  // `session` is the name under which the frame was tracked.
  std::optional<Rigid3d> FrameFromWanted(const TrackedFrame& tracked, LocalMapId session) {
    LivingRelative relative;
    const RelativeIn layer =
        frame_ == TrajectoryFrame::kLocal ? RelativeIn::kLocalLayer : RelativeIn::kGlobalLayer;
    if (!FindLivingRelative(state_, tracked.reference, relative, layer)) return std::nullopt;
    Rigid3d relative_from_camera = relative.relative_from_id * tracked.reference_from_camera;
    if (camera_from_wanted_) relative_from_camera = relative_from_camera * *camera_from_wanted_;
    const bool is_own = local_map_.IsNamed(relative.id.local_map);
    if (frame_ == TrajectoryFrame::kLocal && is_own) {
      const Keyframe& keyframe = *local_map_.map.FindKeyframe(relative.id);
      return keyframe.camera_from_map.Inverse() * relative_from_camera;
    }
    if (state_.global.island_of.at(relative.id.local_map) !=
        state_.global.island_of.at(local_map_.id)) {
      return std::nullopt;
    }
    Similarity3d frame_from_camera = Poses(relative.id.local_map).at(relative.id).Inverse() *
                                     Similarity3d::FromRigid(relative_from_camera);
    if (frame_ == TrajectoryFrame::kLocal) {
      // The frame was tracked against another local map's keyframe: its pose goes back from the
      // island's frame through the newest own keyframe.
      const IslandPoses& own = Poses(local_map_.id);
      frame_from_camera =
          IslandFromLocal(NewestOf(session, own), local_map_, state_.global, own).Inverse() *
          frame_from_camera;
    }
    return Rigid3d{frame_from_camera.rotation, frame_from_camera.translation};
  }

 private:
  // Returns the session's newest keyframe; an id behind all of them where none is left.
  static KeyframeId NewestOf(LocalMapId session, const IslandPoses& own) {
    const KeyframeId behind = {session, KeyframeId::kNoIndex - 1};
    auto it = own.upper_bound(behind);
    if (it == own.begin()) return behind;
    --it;
    return it->first.local_map == session ? it->first : behind;
  }

  const IslandPoses& Poses(LocalMapId id) { return poses_.Of(*state_.FindLocalMap(id)); }

  const MissionState& state_;
  const LocalMapState& local_map_;
  const TrajectoryFrame frame_;
  const std::optional<Rigid3d> camera_from_wanted_;
  const Unplaced all_placed_;
  PoseCache poses_;
};

bool HasTimeBetween(const std::vector<int64_t>& times, int64_t begin, int64_t end) {
  const auto it = std::upper_bound(times.begin(), times.end(), begin);
  return it != times.end() && *it < end;
}

template <typename T>
std::vector<T> Part(const std::vector<T>& of, size_t first, size_t end) {
  return {of.begin() + static_cast<std::ptrdiff_t>(first),
          of.begin() + static_cast<std::ptrdiff_t>(end)};
}

void AppendSession(const MissionState& state, const LocalMapState& local_map,
                   const SessionFrames& session, FrameChain& chain, AgentTrajectory& trajectory) {
  std::vector<TrackedFrame> frames = Part(local_map.frames, session.first, session.end);
  std::stable_sort(frames.begin(), frames.end(), [](const TrackedFrame& a, const TrackedFrame& b) {
    return a.timestamp_ns < b.timestamp_ns;
  });
  std::vector<int64_t> lost = Part(local_map.lost_frames_ns, session.first_lost, session.end_lost);
  std::sort(lost.begin(), lost.end());
  bool gap = !trajectory.poses.empty();
  std::optional<int64_t> before;
  for (const TrackedFrame& tracked : frames) {
    const std::optional<Rigid3d> pose = chain.FrameFromWanted(tracked, session.id);
    if (!pose.has_value()) {
      ++trajectory.left_out;
      gap = true;
      continue;
    }
    gap = gap || (before.has_value() && HasTimeBetween(lost, *before, tracked.timestamp_ns));
    trajectory.poses.push_back(
        {tracked.timestamp_ns, session.id, *pose, state.global.island_of.at(local_map.id), gap, 0});
    before = tracked.timestamp_ns;
    gap = false;
  }
}

}  // namespace

absl::StatusOr<AgentTrajectory> ComputeTrajectory(const MissionState& state,
                                                  const std::string& agent, TrajectoryFrame frame,
                                                  bool all_islands, PosesOf poses_of) {
  AgentTrajectory trajectory;
  trajectory.agent = agent;
  const IslandId reference = state.ReferenceIsland();
  const AgentState& agent_state = state.agents.at(agent);
  for (const LocalMapId& id : agent_state.local_maps) {
    const bool wanted = frame == TrajectoryFrame::kLocal || all_islands ||
                        state.global.island_of.at(id) == reference;
    const LocalMapState& local_map = *state.FindLocalMap(id);
    trajectory.lost += local_map.lost_frames_ns.size();
    if (!wanted) {
      trajectory.left_out += local_map.frames.size();
      continue;
    }
    const auto camera_from_wanted = CameraFromWanted(local_map.Recorded(), poses_of);
    if (!camera_from_wanted.ok()) {
      return absl::FailedPreconditionError(absl::StrCat("agent ", agent, ", local map ",
                                                        ToString(id), ": ",
                                                        camera_from_wanted.status().message()));
    }
    FrameChain chain(state, local_map, frame, *camera_from_wanted);
    for (const SessionFrames& session : SessionsOf(local_map)) {
      AppendSession(state, local_map, session, chain, trajectory);
    }
  }
  // What an agent localised has no local frame.
  if (frame == TrajectoryFrame::kLocal) {
    LeaveOutLocalised(agent_state, trajectory);
    return trajectory;
  }
  const absl::Status appended =
      AppendLocalised(state, agent_state, all_islands, poses_of, trajectory);
  if (!appended.ok()) return appended;
  return trajectory;
}

}  // namespace corbslam::map_store

#include "services/simulation/motion/pose_sequence.h"

#include <algorithm>
#include <cstddef>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/geometry/lie.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

// Returns the slope at the middle of three values: that of the parabola through them.
Eigen::Vector3d Slope(const Eigen::Vector3d& step_before, double before_s,
                      const Eigen::Vector3d& step_after, double after_s) {
  return (after_s * step_before / before_s + before_s * step_after / after_s) /
         (before_s + after_s);
}

// Returns the way from 0 to `step` over `duration_s`, at share u.
Eigen::Vector3d Hermite(const Eigen::Vector3d& step, const Eigen::Vector3d& slope_at_start,
                        const Eigen::Vector3d& slope_at_end, double duration_s, double u) {
  const double v = 1 - u;
  return u * u * (3 - 2 * u) * step + duration_s * u * v * (v * slope_at_start - u * slope_at_end);
}

// The way from one pose to the next: metres, and radians in the first one's frame.
struct Step {
  Eigen::Vector3d translation;
  Eigen::Vector3d rotation;
  double duration_s;
};

Step StepFrom(const Trajectory& trajectory, size_t i) {
  const StampedPose& from = trajectory[i];
  const StampedPose& to = trajectory[i + 1];
  return {to.world_from_camera.translation - from.world_from_camera.translation,
          LogSO3(from.world_from_camera.rotation.conjugate() * to.world_from_camera.rotation),
          1e-9 * static_cast<double>(to.timestamp_ns - from.timestamp_ns)};
}

// Returns the pose at share u of the way from pose i to i + 1.
Rigid3d Interpolate(const Trajectory& trajectory, size_t i, double u) {
  const Step own = StepFrom(trajectory, i);
  // At the ends the path is taken to go on as it does.
  const Step before = i > 0 ? StepFrom(trajectory, i - 1) : own;
  const Step after = i + 2 < trajectory.size() ? StepFrom(trajectory, i + 1) : own;
  const auto bend = [&](Eigen::Vector3d Step::*part) {
    return Hermite(own.*part, Slope(before.*part, before.duration_s, own.*part, own.duration_s),
                   Slope(own.*part, own.duration_s, after.*part, after.duration_s), own.duration_s,
                   u);
  };
  const Rigid3d& from = trajectory[i].world_from_camera;
  return {(from.rotation * ExpSO3(bend(&Step::rotation))).normalized(),
          from.translation + bend(&Step::translation)};
}

absl::StatusOr<size_t> CountFields(const std::string& path) {
  size_t fields = 0;
  RETURN_IF_ERROR(ForEachLine(path, [&](int, absl::string_view text) -> absl::Status {
    const std::vector<absl::string_view> parts =
        absl::StrSplit(text, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    if (fields == 0) fields = parts.size();
    return absl::OkStatus();
  }));
  return fields;
}

}  // namespace

absl::StatusOr<PoseSequence> PoseSequence::Make(const Trajectory& trajectory) {
  if (trajectory.size() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("a path of ", trajectory.size(), " poses: at least 2 are needed"));
  }
  Trajectory from_zero = trajectory;
  for (size_t i = 0; i < trajectory.size(); ++i) {
    from_zero[i].timestamp_ns -= trajectory.front().timestamp_ns;
    if (i > 0 && from_zero[i].timestamp_ns <= from_zero[i - 1].timestamp_ns) {
      return absl::InvalidArgumentError(
          absl::StrCat("pose ", i, " is not later than the one before"));
    }
  }
  return PoseSequence(std::move(from_zero));
}

absl::StatusOr<PoseSequence> PoseSequence::Make(const std::vector<Rigid3d>& world_from_camera,
                                                int64_t period_ns) {
  Trajectory trajectory;
  trajectory.reserve(world_from_camera.size());
  for (const Rigid3d& pose : world_from_camera) {
    trajectory.push_back({static_cast<int64_t>(trajectory.size()) * period_ns, pose});
  }
  return Make(trajectory);
}

Rigid3d PoseSequence::PoseAt(int64_t time_ns) const {
  if (time_ns <= 0) return trajectory_.front().world_from_camera;
  if (time_ns >= duration_ns()) return trajectory_.back().world_from_camera;
  const auto after = std::upper_bound(
      trajectory_.begin(), trajectory_.end(), time_ns,
      [](int64_t time, const StampedPose& pose) { return time < pose.timestamp_ns; });
  const auto i = static_cast<size_t>(after - trajectory_.begin()) - 1;
  const StampedPose& from = trajectory_[i];
  if (from.timestamp_ns == time_ns) return from.world_from_camera;
  return Interpolate(trajectory_, i,
                     static_cast<double>(time_ns - from.timestamp_ns) /
                         static_cast<double>(trajectory_[i + 1].timestamp_ns - from.timestamp_ns));
}

Rigid3d TurnedBack(const Rigid3d& world_from_camera) {
  const Eigen::Quaterniond half_turn(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()));
  return {(world_from_camera.rotation * half_turn).normalized(), world_from_camera.translation};
}

absl::StatusOr<PoseSequence> ReadPoseSequence(const std::string& path) {
  ASSIGN_OR_RETURN(const size_t fields, CountFields(path));
  ASSIGN_OR_RETURN(const Trajectory trajectory,
                   fields == 8 ? ReadTumTrajectory(path) : ReadKittiTrajectory(path));
  absl::StatusOr<PoseSequence> sequence = PoseSequence::Make(trajectory);
  if (!sequence.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", sequence.status().message()));
  }
  return sequence;
}

}  // namespace corbslam

#include "services/programs/robot/told_poses.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "slam/evaluation/pose_header.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/geometry/same_motion.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

Rigid3d InGlobal(const Similarity3d& global_from_local, const Rigid3d& local_from_camera) {
  return {(global_from_local.rotation * local_from_camera.rotation).normalized(),
          global_from_local * local_from_camera.translation};
}

std::string LocalFile(const std::string& stem) { return stem + ".local.tum"; }
std::string GlobalFile(const std::string& stem) { return stem + ".global.tum"; }

std::string Comment(const std::string& frame) {
  return absl::StrCat(PoseHeaderLine(PosesOf::kRecordedCamera), " as told when each frame came, ",
                      frame, ": timestamp tx ty tz qx qy qz qw");
}

}  // namespace

void ToldPoses::Add(const TrackingResult& result) {
  if (result.state != TrackingState::kTracking) {
    last_.reset();
    return;
  }
  has_several_ |= local_map_.value_or(result.local_map) != result.local_map;
  local_map_ = result.local_map;
  if (has_several_) {
    paths_.local.clear();
  } else if (keeps_paths_) {
    paths_.local.push_back(
        {result.timestamp_ns, result.camera_from_local.Inverse() * camera_from_recorded_});
  }
  if (result.global_from_local.has_value()) {
    AddGlobal(result, *result.global_from_local);
  } else {
    last_.reset();
  }
}

void ToldPoses::AddGlobal(const TrackingResult& result, const Similarity3d& global_from_local) {
  const Rigid3d global_from_camera =
      InGlobal(global_from_local, result.camera_from_local.Inverse());
  if (keeps_paths_) {
    paths_.global.push_back({result.timestamp_ns, global_from_camera * camera_from_recorded_});
  }
  const Rigid3d odom_from_camera = result.odom_from_camera.value_or(Rigid3d::Identity());
  if (last_.has_value() &&
      (last_->epoch != result.epoch || !AreSame(last_->global_from_local, global_from_local))) {
    Rigid3d motion = last_->odom_from_camera.Inverse() * odom_from_camera;
    motion.translation *= global_from_local.scale;
    const Rigid3d expected = last_->global_from_camera * motion;
    const double jump_m = (global_from_camera.translation - expected.translation).norm();
    ++jumps_.count;
    jumps_.largest_m = std::max(jumps_.largest_m, jump_m);
    jumps_.sum_m += jump_m;
  }
  last_ = {result.epoch, global_from_local, global_from_camera, odom_from_camera};
}

void AddJumps(const ToldJumps& jumps, RobotReport& report) {
  report.told_jumps = jumps.count;
  report.told_jumps_m = jumps.sum_m;
  report.told_largest_jump_m = jumps.largest_m;
}

absl::Status WriteToldPaths(const ToldPaths& paths, const std::string& stem) {
  RETURN_IF_ERROR(
      WriteTumTrajectory(paths.local, LocalFile(stem), Comment("in the frame of the local map")));
  return WriteTumTrajectory(paths.global, GlobalFile(stem),
                            Comment("in the mission's global frame"));
}

absl::StatusOr<ToldPaths> ReadToldPaths(const std::string& stem) {
  ToldPaths paths;
  ASSIGN_OR_RETURN(paths.local, ReadTumTrajectory(LocalFile(stem)));
  ASSIGN_OR_RETURN(paths.global, ReadTumTrajectory(GlobalFile(stem)));
  return paths;
}

}  // namespace corbslam::services

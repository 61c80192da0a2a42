#include "services/tool/export/mcap/testing/made_up_mission.h"

#include "slam/util/status_macros.h"

namespace corbslam::testing {
namespace {

using services::RecordedMission;
using services::RecordedTrajectory;
using services::ToldMap;

constexpr uint32_t kKeyframes = 4;
constexpr uint32_t kPoints = 50;

// Adds a local map whose keyframes stand in a row along z, from `x` on the x axis.
void AddLocalMap(LocalMapId id, float x, ToldMap::Island& island) {
  for (uint32_t i = 0; i < kKeyframes; ++i) {
    ToldMap::Keyframe keyframe;
    keyframe.island_from_camera.translation = {x, 0, 2.0 * i};
    if (i > 0) keyframe.parent = {id, i - 1};
    island.keyframes[{id, i}] = keyframe;
  }
  for (uint32_t i = 0; i < kPoints; ++i) {
    island.points[{id, i}] = {x + 0.5F, 0.25F * static_cast<float>(i), 1.5F};
  }
}

ToldMap MakeMap(uint64_t revision, bool fused) {
  ToldMap map;
  map.version = revision + 1;
  map.revision = revision;
  map.agents = {{kAlphas, "alpha"}, {kHostiles, kHostileName}};
  map.islands[kAlphas].in_global_frame = true;
  AddLocalMap(kAlphas, 0, map.islands[kAlphas]);
  AddLocalMap(kHostiles, 3, map.islands[fused ? kAlphas : kHostiles]);
  return map;
}

RecordedTrajectory MakeTrajectory(const std::string& robot, int64_t first_ns, double x) {
  RecordedTrajectory trajectory;
  trajectory.robot = robot;
  trajectory.island = kAlphas;
  trajectory.in_global_frame = true;
  trajectory.drive_begins_ns = first_ns;
  for (int i = 0; i < 10; ++i) {
    StampedPose& pose = trajectory.poses.emplace_back();
    pose.timestamp_ns = first_ns + i * 100'000'000;
    pose.world_from_camera.translation = {x, 0, 0.6 * i};
  }
  trajectory.pieces = {0, 4};
  return trajectory;
}

}  // namespace

MadeUpMission MakeUpMission() {
  MadeUpMission made_up;
  RecordedMission& mission = made_up.mission;
  mission.mission = "lab";
  mission.colours = services::ChooseColours({"alpha", kHostileName});
  mission.overlaps = {{{kAlphas, 1}, {kHostiles, 1}, 5}, {{kAlphas, 2}, {kHostiles, 2}, 0}};
  mission.notes = {{5, false, "overlap 1: accepted"},
                   {1, true, std::string("lost \xff\n") + kHostileName},
                   {~uint64_t{0}, false, "overlap 2: refused, the scales disagree"}};
  made_up.moments = {MakeMap(0, false), MakeMap(1, false), MakeMap(5, true)};
  // Their clocks have nothing to do with each other.
  made_up.trajectories = {MakeTrajectory("alpha", 1'403'636'579'763'555'584, 0),
                          MakeTrajectory(kHostileName, 7, 3)};
  return made_up;
}

absl::Status Record(const MadeUpMission& made_up, const std::string& path) {
  ASSIGN_OR_RETURN(services::MissionRecording recording,
                   services::MissionRecording::Create(path, made_up.mission));
  const ToldMap end = made_up.moments.empty() ? ToldMap() : made_up.moments.back();
  if (made_up.mission.clock == services::RecordingClock::kRobots) {
    RETURN_IF_ERROR(recording.BeginDrives(end, made_up.trajectories));
  }
  for (const ToldMap& map : made_up.moments) RETURN_IF_ERROR(recording.AddMoment(map));
  RETURN_IF_ERROR(recording.End(end, made_up.trajectories));
  return recording.Finish();
}

}  // namespace corbslam::testing

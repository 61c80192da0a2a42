#include "services/simulation/sequence/simulated_world.h"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "services/simulation/motion/drives.h"
#include "services/simulation/worlds/floor_world.h"
#include "services/simulation/worlds/room_world.h"
#include "services/simulation/worlds/street_world.h"

namespace corbslam {
namespace {

FloorPlan PlanFloor(const SimulationSpec& spec) {
  return MakeFloorPlan({.seed = spec.world_seed.value_or(spec.seed),
                        .rooms_x = spec.rooms_x,
                        .rooms_z = spec.rooms_z,
                        .look_alike_corridors = spec.look_alike});
}

int64_t PeriodOf(double rate_hz) { return std::llround(1e9 / rate_hz); }

absl::StatusOr<PoseSequence> MakeFloorWay(const SimulationSpec& spec) {
  const std::vector<Eigen::Vector2d> waypoints = TourOfFloor(PlanFloor(spec), spec.seed);
  if (spec.motion == FloorMotion::kFly) {
    return PoseSequence::Make(FlyAlong(waypoints, spec.seed), PeriodOf(kDroneRate_hz));
  }
  return PoseSequence::Make(WalkAlong(waypoints, spec.seed), PeriodOf(kWalkerRate_hz));
}

Scene BuildStreets(const SimulationSpec& spec, const PoseSequence& way) {
  StreetOptions options;
  options.seed = spec.world_seed.value_or(spec.seed);
  options.frame_rate_hz = kCarRate_hz;
  options.moving_cars = spec.moving_cars;
  options.look_alike = spec.look_alike;
  const int64_t period_ns = PeriodOf(options.frame_rate_hz);
  std::vector<Rigid3d> poses;
  for (int64_t time_ns = 0; time_ns <= way.duration_ns(); time_ns += period_ns) {
    poses.push_back(way.PoseAt(time_ns));
  }
  return BuildStreetScene(poses, options);
}

Scene BuildRoom(const SimulationSpec& spec, const PoseSequence& way) {
  std::vector<Rigid3d> poses;
  for (const StampedPose& pose : way.trajectory()) poses.push_back(pose.world_from_camera);
  return BuildRoomScene(poses, spec.world_seed.value_or(spec.seed));
}

}  // namespace

absl::StatusOr<PoseSequence> MakeWay(const SimulationSpec& spec) {
  switch (spec.world) {
    case SimulatedWorld::kCity:
      return PoseSequence::Make(DriveThroughTown({.seed = spec.seed, .length_m = spec.length_m}),
                                PeriodOf(kCarRate_hz));
    case SimulatedWorld::kPath:
      return ReadPoseSequence(spec.poses);
    case SimulatedWorld::kFloor:
      return MakeFloorWay(spec);
  }
  return absl::InvalidArgumentError("unknown world");
}

Scene BuildWorld(const SimulationSpec& spec, const PoseSequence& way) {
  if (spec.around == PathSurroundings::kRoom) return BuildRoom(spec, way);
  return spec.world == SimulatedWorld::kFloor ? BuildFloorScene(PlanFloor(spec))
                                              : BuildStreets(spec, way);
}

}  // namespace corbslam

#include "services/simulation/motion/drives.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "services/simulation/dice.h"
#include "services/simulation/motion/street_tour.h"
#include "services/simulation/motion/waves.h"

namespace corbslam {
namespace {

constexpr double kGravity_mps2 = 9.81;

// What seeds are drawn for.
enum Purpose : uint64_t { kCorners = 100, kSpeeds, kHills, kHeight, kPitch, kRoll, kYaw, kAside };

uint64_t SeedFor(uint64_t seed, Purpose purpose) { return Dice::For(seed, purpose, 0).Next(); }

// Pitch is positive with the nose up, roll with the right side down.
Rigid3d MakePose(const Eigen::Vector3d& position, double yaw, double pitch, double roll) {
  return {(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) *
           Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
              .normalized(),
          position};
}

Eigen::Vector3d InSpace(const Eigen::Vector2d& place, double height_m) {
  return {place.x(), -height_m, place.y()};
}
Eigen::Vector2d Forward(double heading) { return {std::sin(heading), std::cos(heading)}; }
Eigen::Vector2d Right(double heading) { return {std::cos(heading), -std::sin(heading)}; }

// Moves the path so that the first point is the origin and the way begins along z.
PlanePath StartAtOrigin(PlanePath path) {
  if (path.points.empty()) return path;
  const double heading = path.headings_rad.front();
  const Eigen::Vector2d origin = path.points.front();
  for (Eigen::Vector2d& point : path.points) {
    const Eigen::Vector2d from_start = point - origin;
    point = {Right(heading).dot(from_start), Forward(heading).dot(from_start)};
  }
  for (double& each : path.headings_rad) each -= heading;
  return path;
}

PlanePath PathThroughTown(const CarDriveOptions& options) {
  const StreetTour tour = MakeStreetTour({.seed = options.seed, .length_m = options.length_m});
  Dice dice(SeedFor(options.seed, kCorners));
  std::vector<double> corners_m;
  for (size_t i = 0; i < tour.crossings.size(); ++i) corners_m.push_back(dice.Uniform(6, 10));
  PlanePathOptions path;
  path.closed = true;
  path.lead_out_m = 40;
  return StartAtOrigin(MakePlanePath(tour.crossings, path, corners_m));
}

// Draws speeds as the driver feels like: not every street is driven as fast.
std::vector<double> StreetSpeeds(uint64_t seed, const PlanePath& path) {
  const Waves mood(SeedFor(seed, kSpeeds), 1.2, 80, 400);
  std::vector<double> speeds;
  for (size_t i = 0; i < path.points.size(); ++i) {
    const double at_m = path.spacing_m * static_cast<double>(i);
    speeds.push_back(std::max(10.5 + mood(at_m), 2.0));
  }
  return speeds;
}

// Indoors somebody who turns on the spot does so while going on slowly: headings are smoothed over
// a longer way than points.
PlanePath IndoorPath(const std::vector<Eigen::Vector2d>& waypoints, double point_smoothing_m,
                     double heading_smoothing_m) {
  PlanePathOptions options;
  options.spacing_m = 0.02;
  options.corner_m = 0.5;
  options.least_radius_m = 0;
  options.point_smoothing_m = point_smoothing_m;
  options.heading_smoothing_m = heading_smoothing_m;
  return MakePlanePath(waypoints, options);
}

}  // namespace

std::vector<TravelSample> PlanDriveThroughTown(const CarDriveOptions& options) {
  const PlanePath path = PathThroughTown(options);
  return SampleTravel(path, TravelLimits(), kCarRate_hz, StreetSpeeds(options.seed, path));
}

std::vector<Rigid3d> DriveThroughTown(const CarDriveOptions& options) {
  // The body turns by so many radians for each m/s^2.
  constexpr double kPitchPerForward = 0.007;
  constexpr double kRollPerLateral = -0.009;
  const Waves hills(SeedFor(options.seed, kHills), 2, 160, 500);
  const Waves height(SeedFor(options.seed, kHeight), 0.010, 6, 40);
  const Waves pitch(SeedFor(options.seed, kPitch), 0.0025, 5, 30);
  const Waves roll(SeedFor(options.seed, kRoll), 0.003, 5, 30);
  const Waves yaw(SeedFor(options.seed, kYaw), 0.001, 8, 40);
  std::vector<Rigid3d> poses;
  for (const TravelSample& at : PlanDriveThroughTown(options)) {
    const double ground_m = hills(at.position) - hills(Eigen::Vector2d(0, 0));
    const double slope = hills.Gradient(at.position).dot(Forward(at.heading_rad));
    poses.push_back(MakePose(
        InSpace(at.position, ground_m + height(at.distance_m)), at.heading_rad + yaw(at.distance_m),
        std::atan(slope) + kPitchPerForward * at.forward_mps2 + pitch(at.distance_m),
        kRollPerLateral * at.lateral_mps2 + roll(at.distance_m)));
  }
  return poses;
}

std::vector<Rigid3d> WalkAlong(const std::vector<Eigen::Vector2d>& waypoints, uint64_t seed) {
  constexpr double kCameraHeight_m = 1.5;
  constexpr double kLookAround_rad = 0.35;  // Largest angle between way and camera, about.
  constexpr double kStep_m = 0.7;
  constexpr double kPerStep = 2 * std::numbers::pi / kStep_m;
  const TravelLimits limits = {.speed_mps = 1.2,
                               .accelerate_mps2 = 0.6,
                               .brake_mps2 = 0.8,
                               .lateral_mps2 = 0.7,
                               .yaw_rate_radps = 0.9};
  const Waves look(SeedFor(seed, kYaw), 0.5 * kLookAround_rad, 5, 20);
  const Waves nod(SeedFor(seed, kPitch), 0.2 * kLookAround_rad, 5, 20);
  std::vector<Rigid3d> poses;
  for (const TravelSample& at :
       SampleTravel(IndoorPath(waypoints, 0.15, 0.4), limits, kWalkerRate_hz)) {
    const double step = kPerStep * at.distance_m;
    const Eigen::Vector2d aside = 0.012 * std::sin(0.5 * step) * Right(at.heading_rad);
    poses.push_back(MakePose(InSpace(at.position + aside, kCameraHeight_m + 0.016 * std::cos(step)),
                             at.heading_rad + look(at.time_s),
                             nod(at.time_s) + 0.005 * std::sin(step),
                             0.006 * std::sin(0.5 * step)));
  }
  return poses;
}

std::vector<Rigid3d> FlyAlong(const std::vector<Eigen::Vector2d>& waypoints, uint64_t seed) {
  constexpr double kLowest_m = 0.9;
  constexpr double kHighest_m = 1.9;
  const TravelLimits limits = {.speed_mps = 1.5,
                               .accelerate_mps2 = 0.8,
                               .brake_mps2 = 0.8,
                               .lateral_mps2 = 0.9,
                               .yaw_rate_radps = 0.9};
  const double middle_m = 0.5 * (kLowest_m + kHighest_m);
  const double reach_m = 0.5 * (kHighest_m - kLowest_m);
  const Waves climb(SeedFor(seed, kHeight), 0.5 * reach_m, 6, 25);
  const Waves aside(SeedFor(seed, kAside), 0.015, 2, 8);
  const Waves roll(SeedFor(seed, kRoll), 0.01, 1, 4);
  const Waves pitch(SeedFor(seed, kPitch), 0.01, 1, 4);
  const Waves yaw(SeedFor(seed, kYaw), 0.02, 2, 8);
  std::vector<Rigid3d> poses;
  for (const TravelSample& at :
       SampleTravel(IndoorPath(waypoints, 0.25, 0.5), limits, kDroneRate_hz)) {
    const double height_m = std::clamp(middle_m + climb(at.distance_m), kLowest_m, kHighest_m);
    poses.push_back(
        MakePose(InSpace(at.position + aside(at.time_s) * Right(at.heading_rad), height_m),
                 at.heading_rad + yaw(at.time_s),
                 -std::atan(at.forward_mps2 / kGravity_mps2) + pitch(at.time_s),
                 std::atan(at.lateral_mps2 / kGravity_mps2) + roll(at.time_s)));
  }
  return poses;
}

}  // namespace corbslam

#include "services/simulation/sequence/truth_error.h"

#include <array>
#include <cmath>
#include <numbers>

#include "services/simulation/dice.h"

namespace corbslam {
namespace {

constexpr std::array<double, 3> kPeriods_s = {11, 31, 83};

double Phase(uint64_t seed, uint64_t axis, uint64_t wave) {
  return Dice((seed * 31 + axis) * 31 + wave).Uniform(0, 2 * std::numbers::pi);
}

// The sum has variance 1 over long times: each oscillation has variance 1/3.
double Wander(uint64_t seed, uint64_t axis, double time_s) {
  double sum = 0;
  for (uint64_t wave = 0; wave < kPeriods_s.size(); ++wave) {
    const double turns = time_s / kPeriods_s[wave];
    sum += std::sin(2 * std::numbers::pi * turns + Phase(seed, axis, wave));
  }
  return sum * std::sqrt(2.0 / static_cast<double>(kPeriods_s.size()));
}

Eigen::Vector3d Wander3(uint64_t seed, uint64_t first_axis, double time_s) {
  return {Wander(seed, first_axis, time_s), Wander(seed, first_axis + 1, time_s),
          Wander(seed, first_axis + 2, time_s)};
}

}  // namespace

Rigid3d MeasuredPose(const Rigid3d& world_from_camera, double time_s, const TruthError& error) {
  const double radians = error.orientation_deg * std::numbers::pi / 180;
  const Eigen::Vector3d turn = radians * Wander3(error.seed, 3, time_s);
  Rigid3d measured = world_from_camera;
  measured.translation += error.position_m * Wander3(error.seed, 0, time_s);
  if (turn.norm() > 0) {
    measured.rotation =
        measured.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  }
  return measured;
}

}  // namespace corbslam

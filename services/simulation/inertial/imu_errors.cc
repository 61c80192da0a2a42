#include "services/simulation/inertial/imu_errors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "services/simulation/dice.h"

namespace corbslam {
namespace {

// What seeds are drawn for.
enum Purpose : uint64_t { kTurnOn = 200, kWalk, kWhite, kPhases, kWarmth };

constexpr double kTurn_rad = 2 * std::numbers::pi;

// A number for each axis of both instruments.
struct Axes {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();

  Axes& operator+=(const Axes& other) {
    gyro += other.gyro;
    accel += other.accel;
    return *this;
  }
  friend Axes operator*(const GyroAccel& scale, const Axes& axes) {
    return {scale.gyro_rps * axes.gyro, scale.accel_mps2 * axes.accel};
  }
};

// Draws by `draw` for each axis, in one order with any compiler.
template <typename Draw>
Axes DrawAxes(Dice& dice, const Draw& draw) {
  Axes axes;
  for (Eigen::Vector3d* part : {&axes.gyro, &axes.accel}) {
    for (double& axis : *part) axis = draw(dice);
  }
  return axes;
}

// Box and Muller: A note on the generation of random normal deviates, 1958.
double Normal(Dice& dice) {
  const double radius = std::sqrt(-2 * std::log(1 - dice.Uniform(0, 1)));
  return radius * std::cos(dice.Uniform(0, kTurn_rad));
}
Axes Normals(Dice& dice) { return DrawAxes(dice, Normal); }
Axes Phases(Dice& dice) {
  return DrawAxes(dice, [](Dice& d) { return d.Uniform(0, kTurn_rad); });
}
Axes Signs(Dice& dice) {
  return DrawAxes(dice, [](Dice& d) { return d.Chance(0.5) ? 1.0 : -1.0; });
}

GyroAccel TurnOnBias(const SimulatedImu& imu) {
  if (imu.bias.has_value()) return *imu.bias;
  switch (imu.grade.value_or(ImuGrade::kIdeal)) {
    case ImuGrade::kIdeal:
      return {};
    case ImuGrade::kGood:
      return {.gyro_rps = 0.003, .accel_mps2 = 0.03};
    case ImuGrade::kPhone:
      return {.gyro_rps = 0.01, .accel_mps2 = 0.1};
  }
  return {};
}

// Returns what biases add to the samples of a time.
class Biases {
 public:
  Biases(const SimulatedImu& imu, uint64_t seed)
      : warming_(imu.warming), walking_(Dice::For(seed, kWalk, 0)) {
    const ImuNoise noise = NoiseOf(imu.grade.value_or(ImuGrade::kIdeal));
    step_ = {noise.gyro_walk / std::sqrt(imu.rate_hz), noise.accel_walk / std::sqrt(imu.rate_hz)};
    Dice turn_on = Dice::For(seed, kTurnOn, 0);
    bias_ = TurnOnBias(imu) * Normals(turn_on);
    Dice warmth = Dice::For(seed, kWarmth, 0);
    warm_ = warming_.change * Signs(warmth);
  }

  // To be called for one sample after the other.
  Axes NextAt(double since_first_s) {
    Axes now = bias_;
    if (warming_.within_s > 0) {
      const double share = 1 - std::exp(-since_first_s / warming_.within_s);
      now += GyroAccel{share, share} * warm_;
    }
    bias_ += step_ * Normals(walking_);
    return now;
  }

 private:
  const ImuWarming warming_;
  GyroAccel step_;
  Axes bias_;
  Axes warm_;
  Dice walking_;
};

// The mean of the vibration over the period of a sample, as MeasureMotion's are.
Axes VibrationAt(const SimulatedImu& imu, const Axes& phases, double time_s) {
  const double half_turned = std::numbers::pi * imu.vibration.frequency_hz / imu.rate_hz;
  const double left = half_turned > 0 ? std::sin(half_turned) / half_turned : 1;
  const auto swing = [&](double phase) {
    return left * std::sin(kTurn_rad * imu.vibration.frequency_hz * time_s + phase);
  };
  return imu.vibration.amplitude *
         Axes{phases.gyro.unaryExpr(swing), phases.accel.unaryExpr(swing)};
}

void CutOff(double range, Eigen::Vector3d& measured) {
  if (range > 0) measured = measured.cwiseMax(-range).cwiseMin(range);
}

bool IsInGap(const SimulatedImu& imu, double time_s) {
  return std::any_of(imu.gaps.begin(), imu.gaps.end(), [&](const ImuGap& gap) {
    return time_s >= gap.from_s && time_s < gap.from_s + gap.duration_s;
  });
}

}  // namespace

ImuSamples WithErrors(const SimulatedImu& imu, uint64_t seed, ImuSamples ideal) {
  const ImuNoise noise = NoiseOf(imu.grade.value_or(ImuGrade::kIdeal));
  const double root = std::sqrt(imu.rate_hz);
  const GyroAccel white = {noise.gyro * root, noise.accel * root};
  Biases biases(imu, seed);
  Dice whites = Dice::For(seed, kWhite, 0);
  Dice phase_dice = Dice::For(seed, kPhases, 0);
  const Axes phases = Phases(phase_dice);
  ImuSamples samples;
  samples.reserve(ideal.size());
  for (ImuSample& sample : ideal) {
    const double time_s = 1e-9 * static_cast<double>(sample.timestamp_ns);
    Axes error = white * Normals(whites);
    error += biases.NextAt(time_s - 1e-9 * static_cast<double>(ideal.front().timestamp_ns));
    error += VibrationAt(imu, phases, time_s);
    if (IsInGap(imu, time_s)) continue;
    sample.angular_velocity_rps += error.gyro;
    sample.specific_force_mps2 += error.accel;
    CutOff(imu.range.gyro_rps, sample.angular_velocity_rps);
    CutOff(imu.range.accel_mps2, sample.specific_force_mps2);
    samples.push_back(sample);
    samples.back().timestamp_ns += std::llround(1e9 * imu.late_s);
  }
  return samples;
}

}  // namespace corbslam

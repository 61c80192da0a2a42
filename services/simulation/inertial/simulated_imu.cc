#include "services/simulation/inertial/simulated_imu.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "slam/util/median.h"

namespace corbslam {
namespace {

double RateOf(const ImuSamples& samples) {
  std::vector<double> intervals_s;
  for (size_t i = 1; i < samples.size(); ++i) {
    const int64_t interval_ns = samples[i].timestamp_ns - samples[i - 1].timestamp_ns;
    intervals_s.push_back(1e-9 * static_cast<double>(interval_ns));
  }
  return intervals_s.empty() ? 0 : 1 / MeanMedian(std::move(intervals_s));
}

}  // namespace

Rigid3d EurocImuFromCamera() {
  // T_BS of cam0 in the sequences' sensor.yaml.
  Eigen::Matrix3d rotation;
  rotation << 0.0148655429818, -0.999880929698, 0.00414029679422,  //
      0.999557249008, 0.0149672133247, 0.025715529948,             //
      -0.0257744366974, 0.00375618835797, 0.999660727178;
  return {Eigen::Quaterniond(rotation).normalized(),
          {-0.0216401454975, -0.064676986768, 0.00981073058949}};
}

ImuNoise NoiseOf(ImuGrade grade) {
  switch (grade) {
    case ImuGrade::kIdeal:
      return {.gyro = 0, .accel = 0, .gyro_walk = 0, .accel_walk = 0};
    case ImuGrade::kGood:  // imu0/sensor.yaml of EuRoC's sequences.
      return {.gyro = 1.6968e-4, .accel = 2e-3, .gyro_walk = 1.9393e-5, .accel_walk = 3e-3};
    case ImuGrade::kPhone:
      return {.gyro = 1e-3, .accel = 1e-2, .gyro_walk = 1e-4, .accel_walk = 1e-2};
  }
  return {};
}

ImuCalibration ToldImu(const SimulatedImu& imu) {
  const ImuGrade grade = imu.grade.value_or(ImuGrade::kGood);
  ImuCalibration told;
  told.noise = NoiseOf(grade == ImuGrade::kIdeal ? ImuGrade::kGood : grade);
  told.imu_from_camera = EurocImuFromCamera();
  told.rate_hz = imu.measured != nullptr ? RateOf(*imu.measured) : imu.rate_hz;
  return told;
}

}  // namespace corbslam

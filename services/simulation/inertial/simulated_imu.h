// What the IMU of a simulated robot is, and what goes wrong with it.
#ifndef CORBSLAM_SERVICES_SIMULATION_INERTIAL_SIMULATED_IMU_H_
#define CORBSLAM_SERVICES_SIMULATION_INERTIAL_SIMULATED_IMU_H_

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/inertial/imu.h"

namespace corbslam {

enum class ImuGrade {
  kIdeal,  // Without noise and biases.
  kGood,   // An ADIS16448, as EuRoC's.
  kPhone,  // Cheap, as in telephones.
};

// One number of the gyroscope, rad/s, and one of the accelerometer, m/s2.
struct GyroAccel {
  double gyro_rps = 0;
  double accel_mps2 = 0;
  friend bool operator==(const GyroAccel&, const GyroAccel&) = default;
};

// Rotors shake the IMU at one frequency, about and along each axis with a phase of its own. What
// the camera moves by is too little to be seen.
struct ImuVibration {
  double frequency_hz = 0;
  GyroAccel amplitude;
  friend bool operator==(const ImuVibration&, const ImuVibration&) = default;
};

// From the first sample on the biases go aside by so much (with signs of the seed), first fast,
// then slowly: 1/e of it is still to come after `within_s`.
struct ImuWarming {
  GyroAccel change;
  double within_s = 0;
  friend bool operator==(const ImuWarming&, const ImuWarming&) = default;
};

// Seconds of the sequence's own time.
struct ImuGap {
  double from_s = 0;
  double duration_s = 0;
  friend bool operator==(const ImuGap&, const ImuGap&) = default;
};

struct SimulatedImu {
  std::optional<ImuGrade> grade;  // Absent: there is no IMU, unless `file` is set.
  // What a real one measured while it moved along the poses of a path, and the file that it is
  // from. By the clock of the poses.
  std::string file;
  std::shared_ptr<const ImuSamples> measured;
  double rate_hz = 200;
  double late_s = 0;  // Stamps are later than the pictures' by this, and nobody is told.
  // Standard deviation about each axis of what the biases are at the first sample. Absent: the
  // grade's.
  std::optional<GyroAccel> bias;
  ImuVibration vibration;
  ImuWarming warming;
  GyroAccel range;  // Most that is measured, either way; 0: any.
  std::vector<ImuGap> gaps;

  bool is_there() const { return grade.has_value() || !file.empty(); }
  friend bool operator==(const SimulatedImu&, const SimulatedImu&) = default;
};

// Where EuRoC's IMU sits beside its left camera.
Rigid3d EurocImuFromCamera();

// Returns the densities of a grade. The ideal one has none.
ImuNoise NoiseOf(ImuGrade grade);

// Returns what the robot is told: the densities of the grade; of the ideal one and of a file those
// of kGood, because none would be believed beyond all pictures.
ImuCalibration ToldImu(const SimulatedImu& imu);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_INERTIAL_SIMULATED_IMU_H_

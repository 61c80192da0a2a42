// A recording that is drawn when it is asked for.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATED_SEQUENCE_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATED_SEQUENCE_H_

#include <cstddef>
#include <cstdint>
#include <memory>

#include "absl/status/statusor.h"
#include "services/simulation/sequence/simulation_spec.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/rigid3.h"
#include "slam/sensor/sensor.h"

namespace corbslam {

// A sequence is thread-safe. The same spec gives the same bytes, whoever asks in whatever order and
// however many threads draw. The world is built when the first picture is asked for: calibration,
// times and poses cost little; samples of the IMU are made when they are first asked for.
class SimulatedSequence {
 public:
  // INVALID_ARGUMENT names the option; NOT_FOUND is for a file of poses that is not there.
  static absl::StatusOr<std::unique_ptr<SimulatedSequence>> Make(const SimulationSpec& spec);
  virtual ~SimulatedSequence() = default;

  virtual const SimulationSpec& spec() const = 0;
  // Returns what the robot is told; the pictures differ from it by the spec's errors.
  virtual const SensorCalibration& calibration() const = 0;
  virtual double rate_hz() const = 0;
  virtual size_t frame_count() const = 0;
  // Times grow by one over the rate.
  virtual int64_t timestamp_ns(size_t frame) const = 0;
  // Returns the true pose of the left or the only camera. It is in the frame of the world, which is
  // the same for specs of the same WorldName.
  virtual Rigid3d world_from_camera(size_t frame) const = 0;
  // Returns all that the IMU measures, stamped as it stamps; empty where the robot has none. It
  // begins and ends with the way: the robot was nowhere before.
  virtual const ImuSamples& imu() const = 0;
  // Returns images that are stamped with the frame's time, without what the IMU measured meanwhile.
  virtual absl::StatusOr<SensorImages> Render(size_t frame) const = 0;
};

// Returns the poses of all frames, in the order of time.
Trajectory TrueTrajectory(const SimulatedSequence& sequence);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATED_SEQUENCE_H_

// What a simulated recording is: a world, a way through it, a camera, and what goes wrong.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATION_SPEC_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATION_SPEC_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "services/simulation/inertial/simulated_imu.h"
#include "services/simulation/lens.h"
#include "slam/camera/lens.h"
#include "slam/geometry/rigid3.h"
#include "slam/sensor/sensor.h"

namespace corbslam {

enum class SimulatedWorld {
  kCity,   // A car's tour through streets, made from the seed.
  kPath,   // Streets built along the poses of a file.
  kFloor,  // Rooms and corridors.
};

enum class CameraRig {
  kKitti,  // Rectified stereo 1241 x 376, 10 Hz: the cameras of KITTI's sequence 00.
  kEuroc,  // Rectified stereo 752 x 480, 20 Hz, baseline 0.11 m.
  kRgbd,   // Grey and depth 640 x 480, 30 Hz.
};

enum class FloorMotion { kWalk, kFly };

enum class PathSurroundings { kStreets, kRoom };

// Times are seconds of the sequence's own time, from its first frame on.
struct Blackout {
  double from_s = 0;
  double duration_s = 0;  // 0: none.
  friend bool operator==(const Blackout&, const Blackout&) = default;
};

// What the cameras see until the robot sets off, stage by stage.
struct Beginning {
  double dark_s = 0;     // Black.
  double blurred_s = 0;  // Out of focus.
  double still_s = 0;    // Sharp, and nothing moves but what moves in the world.
  double total_s() const { return dark_s + blurred_s + still_s; }
  friend bool operator==(const Beginning&, const Beginning&) = default;
};

// From at_s on the exposure is multiplied by the factor, until the next step.
struct ExposureStep {
  double at_s = 0;
  double factor = 1;
  friend bool operator==(const ExposureStep&, const ExposureStep&) = default;
};

// A stereo pair as it is built, of any lenses, and what the robot is told of it.
struct SimulatedPair {
  std::string file;  // Of the rig; how the option is written.
  StereoCalibration told;
  RawCamera left;
  RawCamera right;
  Rigid3d right_from_left;
  int width_px = 0;
  int height_px = 0;
  double rate_hz = 0;  // 0: 20 Hz.
};

// At at_s the camera is moved to where it is at to_s of the way, and goes on from there.
struct Kidnap {
  double at_s = 0;
  double to_s = 0;
  friend bool operator==(const Kidnap&, const Kidnap&) = default;
};

struct SimulationSpec {
  SimulatedWorld world = SimulatedWorld::kCity;

  // The world and the way: robots with the same of these are in the same place.
  uint64_t seed = 1;  // Seed of the way, and of the world unless world_seed is set.
  std::optional<uint64_t> world_seed;                    // The option is called world=.
  double length_m = 1500;                                // kCity: length of the tour.
  std::string poses;                                     // kPath: a file in KITTI's or TUM's form.
  PathSurroundings around = PathSurroundings::kStreets;  // kPath.
  int rooms_x = 4;                                       // kFloor.
  int rooms_z = 3;                                       // kFloor.
  bool look_alike = false;
  int moving_cars = 0;  // kCity and kPath.

  // The robot's rig. Absent: rgbd for floors, else kitti.
  std::optional<CameraRig> rig;
  std::optional<SimulatedPair> pair;        // Instead of `rig`.
  FloorMotion motion = FloorMotion::kWalk;  // kFloor.
  double rate_hz = 0;                       // 0: the rig's.
  double picture_scale = 1;                 // Share of the rig's width and height.
  double phase = 0;     // Pictures are taken this share of a frame later on the way.
  bool turned = false;  // Drives the way from its end to its start, looking ahead.
  double start_s = 0;   // Time of the first frame.
  Blackout blackout;
  std::optional<Kidnap> kidnap;

  // What happens to the pictures. The robot's way begins behind the beginning.
  Beginning beginning;
  // After the beginning the robot's speed grows smoothly for so long. 0: it has its speed at once.
  double set_off_s = 0;
  Blackout hand;                             // A hand before both lenses.
  std::vector<ExposureStep> exposure_steps;  // Their times grow.

  // The pictures.
  Lens lens;
  // From the first row's exposure to the last one's; the frame's time and pose are those of its
  // middle. 0: all rows are exposed together.
  double rolling_shutter_ms = 0;
  // Errors of the calibration that the robot believes in.
  double epipolar_error_px = 0;   // The right picture lies lower by this in its middle.
  double disparity_error_px = 0;  // Disparities are too small by this.
  double scale_error = 0;         // The true baseline is longer by this share.
  // Standard deviation of a depth of 1 m in metres; grows with the square of the depth (Khoshelham
  // and Elberink, Sensors 2012).
  double depth_noise_m = 1.425e-3;
  // kRgbd: depth is measured by a camera so far to the right of the grey one, which looks the same
  // way, and registered to the picture (slam/camera/depth_registration.h). 0: from the same place.
  double depth_aside_m = 0;

  SimulatedImu imu;

  // Standard deviations of the ground truth that goes with the pictures; 0: exact.
  double truth_error_m = 0;
  double truth_error_deg = 0;

  int threads = 1;  // Changes speed only.
};

CameraRig RigOf(const SimulationSpec& spec);

// INVALID_ARGUMENT names the option and its value.
absl::Status Validate(const SimulationSpec& spec);

// Returns the part of a spec that says where its frame of the world is: equal for specs whose poses
// may be held against each other.
std::string WorldName(const SimulationSpec& spec);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_SIMULATION_SPEC_H_

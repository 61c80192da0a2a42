// A robot's cameras as they are built: a stereo pair, an RGB-D camera or one camera alone, whatever
// plays or opens them. Its file is described in docs/rig.md.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/calibration/stated_imu.h"
#include "client_agent/source/source_finding.h"
#include "slam/camera/lens.h"
#include "slam/geometry/rigid3.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

enum class RigKind { kStereo, kRgbd, kMonocular };

struct RigCamera {
  RawCamera raw;
  int width_px = 0;
  int height_px = 0;
  // What is added to the stamps of its pictures to get the times at which they were taken. Only
  // what two cameras of a rig differ by is used.
  double time_offset_s = 0;
};

// Where an RGB-D camera's depth comes from and how it is meant.
struct RigDepth {
  double units_per_m = 1000;  // Of pictures of 16 bits; those of floats are in metres.
  // Baseline of the stereo pair that would measure as well; disparities are of it.
  double virtual_baseline_m = 0.08;
  // Values of depth pictures that mean no depth, beside 0, NaN, negative ones and 65535 of 16 bits:
  // in the picture's own units.
  std::vector<double> no_depth;
  // The camera that measures it, where its pictures are not registered to the other's already, and
  // x_in_colour = colour_from_depth * x_in_depth, metres.
  std::optional<RigCamera> camera;
  Rigid3d colour_from_depth;
  double time_offset_s = 0;  // As RigCamera's.
};

struct Rig {
  RigKind kind = RigKind::kStereo;
  // Stereo: left and right. RGB-D: the camera of the grey or colour picture. Monocular: the one.
  std::vector<RigCamera> cameras;
  // Stereo only. The pictures are rectified already: no lens distorts, both cameras have one focal
  // length and principal row, and the right one lies baseline_m along +x of the left one.
  bool rectified = false;
  double baseline_m = 0;
  // Stereo only, unless rectified: x_in_right = right_from_left * x_in_left, metres.
  Rigid3d right_from_left;
  // Stereo only: how wide the rectified pictures of fisheyes are at most (RawStereo).
  double widest_field_deg = RawStereo().widest_field_deg;
  RigDepth depth;  // RGB-D only.
  // Where the first camera sits on the robot, where anybody said so.
  std::optional<Rigid3d> body_from_camera;
  std::optional<StatedImu> imu;
  // Points nearer than this are made from one view. Absent: 40 baselines.
  std::optional<double> close_depth_m;
  std::optional<double> rate_hz;  // Frames a second, where that is known.
  // Picture of the first camera's size, black (0) where the robot itself is seen. Empty: none.
  std::string mask_file;
};

// INVALID_ARGUMENT names the field, its value and what a camera has.
absl::Status Validate(const Rig& rig);

// Finds what is improbable in a rig, as plausibility.h does for every calibration; `from` names its
// file. What no camera has is INVALID_ARGUMENT, unless `trust`; so is a mask that is none,
// NOT_FOUND one that is not there.
absl::StatusOr<SourceFindings> JudgeRig(const Rig& rig, absl::string_view from, bool trust);

// Returns by how much the second pictures of frames, right ones or depth, are stamped too early
// against the first ones.
int64_t SecondTimeOffset_ns(const Rig& rig);

// Returns "a stereo pair", "an RGB-D camera" or "one camera alone".
absl::string_view NameOf(RigKind kind);

// Returns what sensors need; reads the mask. Errors name the field or the mask's file.
absl::StatusOr<SensorCalibration> CalibrationOf(const Rig& rig);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RIG_RIG_H_

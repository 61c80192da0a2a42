#include "services/simulation/sequence/simulation_spec.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "services/simulation/sequence/option_kinds.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

absl::Status Refuse(absl::string_view option, absl::string_view value, absl::string_view wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("simulation option ", option, "=", value, ": wants ", wanted));
}

absl::Status Require(absl::string_view option, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return Refuse(option, absl::StrCat(value), absl::StrCat("a number from ", least, " to ", most));
}

absl::Status ValidateNumbers(const SimulationSpec& spec) {
  for (const SimulationOption& option : SimulationOptions()) {
    if (option.numbers == nullptr) continue;
    for (const double number : option.numbers(spec)) {
      RETURN_IF_ERROR(Require(option.name, number, option.least, option.most));
    }
  }
  double before_s = 0;
  for (const ExposureStep& step : spec.exposure_steps) {
    RETURN_IF_ERROR(Require("exposure_steps", step.at_s, before_s, 1e6));
    RETURN_IF_ERROR(Require("exposure_steps", step.factor, 0.001, 1000));
    before_s = step.at_s;
  }
  return absl::OkStatus();
}

absl::Status ValidatePoses(const SimulationSpec& spec) {
  const bool along_poses = spec.world == SimulatedWorld::kPath;
  if (along_poses && spec.poses.empty()) {
    return Refuse("poses", "", "a file of poses to build the world along");
  }
  if (!along_poses && !spec.poses.empty()) return Refuse("poses", spec.poses, "the world path");
  if (spec.around == PathSurroundings::kStreets) return absl::OkStatus();
  if (!along_poses) return Refuse("around", "room", "the world path; floor has rooms");
  if (spec.moving_cars > 0 || spec.look_alike) {
    return Refuse("around", "room", "neither moving_cars nor look_alike: those are of streets");
  }
  return absl::OkStatus();
}

// A rig file says of what size the pictures are; they may be through any lens.
absl::Status ValidatePair(const SimulationSpec& spec) {
  if (!spec.pair.has_value()) return absl::OkStatus();
  if (spec.picture_scale != 1) {
    return Refuse(
        "picture_scale", absl::StrCat(spec.picture_scale),
        absl::StrCat("1 beside rig=", spec.pair->file, ", which says how large pictures are"));
  }
  if (spec.rolling_shutter_ms != 0) {
    return Refuse("rolling_shutter_ms", absl::StrCat(spec.rolling_shutter_ms),
                  absl::StrCat("the rigs kitti, euroc and rgbd: rows through the lenses of rig=",
                               spec.pair->file, " are all drawn at one time"));
  }
  RETURN_IF_ERROR(corbslam::Validate(spec.pair->left.lens));
  return corbslam::Validate(spec.pair->right.lens);
}

absl::Status ValidateDepth(const SimulationSpec& spec) {
  if (spec.depth_aside_m == 0 || (!spec.pair.has_value() && RigOf(spec) == CameraRig::kRgbd)) {
    return absl::OkStatus();
  }
  return Refuse("depth_aside_m", absl::StrCat(spec.depth_aside_m), "rig=rgbd, which has depth");
}

// What moves without a way between, or reaches a speed in no time, measures nothing that a body
// does.
absl::Status ValidateMotionForImu(const SimulationSpec& spec) {
  if (spec.kidnap.has_value()) {
    return Refuse("kidnap", FormatNumbers({spec.kidnap->at_s, spec.kidnap->to_s}),
                  "no imu: no IMU measures how a camera gets from one place to another at once");
  }
  if (spec.beginning.total_s() > 0 && spec.set_off_s == 0) {
    return Refuse("set_off_s", "0",
                  "more than 0 beside beginning and imu, for example 2: no IMU measures how what "
                  "stood has its speed at once");
  }
  return absl::OkStatus();
}

absl::Status ValidateImuParts(const SimulatedImu& imu) {
  const ImuVibration& vibration = imu.vibration;
  if (vibration.frequency_hz == 0 && vibration.amplitude != GyroAccel{}) {
    return Refuse("imu_vibration",
                  FormatNumbers({0, vibration.amplitude.gyro_rps, vibration.amplitude.accel_mps2}),
                  "a frequency above 0");
  }
  const ImuWarming& warming = imu.warming;
  if (warming.within_s == 0 && warming.change != GyroAccel{}) {
    return Refuse("imu_warming",
                  FormatNumbers({warming.change.gyro_rps, warming.change.accel_mps2, 0}),
                  "a time above 0");
  }
  return absl::OkStatus();
}

// What a real IMU measured is of one flight, and has errors of its own.
absl::Status ValidateMeasuredImu(const SimulationSpec& spec) {
  const SimulatedImu& imu = spec.imu;
  if (imu.file.empty()) return absl::OkStatus();
  if (spec.world != SimulatedWorld::kPath) {
    return Refuse("imu", imu.file, "the world path, along the poses that the IMU had");
  }
  if (spec.turned || spec.set_off_s > 0) {
    return Refuse(spec.turned ? "turned" : "set_off_s",
                  spec.turned ? "1" : FormatReal(spec.set_off_s),
                  absl::StrCat("an imu that is simulated: ", imu.file, " is of one flight"));
  }
  const SimulatedImu plain;
  if (imu.rate_hz != plain.rate_hz || imu.bias != plain.bias || imu.vibration != plain.vibration ||
      imu.warming != plain.warming) {
    return Refuse("imu", imu.file,
                  "no imu_rate, imu_bias, imu_vibration and imu_warming: it has its own");
  }
  return absl::OkStatus();
}

absl::Status ValidateImu(const SimulationSpec& spec) {
  if (spec.imu.is_there()) {
    RETURN_IF_ERROR(ValidateMeasuredImu(spec));
    RETURN_IF_ERROR(ValidateImuParts(spec.imu));
    return ValidateMotionForImu(spec);
  }
  SimulationSpec without = spec;
  without.imu = {};
  for (const SimulationOption& option : SimulationOptions()) {
    if (option.format(spec) == option.format(without)) continue;
    return Refuse(option.name, option.format(spec), "imu=ideal, good or phone beside it");
  }
  return absl::OkStatus();
}

}  // namespace

CameraRig RigOf(const SimulationSpec& spec) {
  return spec.rig.value_or(spec.world == SimulatedWorld::kFloor ? CameraRig::kRgbd
                                                                : CameraRig::kKitti);
}

absl::Status Validate(const SimulationSpec& spec) {
  RETURN_IF_ERROR(ValidateNumbers(spec));
  RETURN_IF_ERROR(ValidatePoses(spec));
  RETURN_IF_ERROR(ValidatePair(spec));
  RETURN_IF_ERROR(ValidateImu(spec));
  return ValidateDepth(spec);
}

std::string WorldName(const SimulationSpec& spec) {
  switch (spec.world) {
    case SimulatedWorld::kCity:
      return absl::StrCat("city ", spec.seed, " ", spec.world_seed.value_or(spec.seed), " ",
                          spec.length_m, " ", spec.look_alike);
    case SimulatedWorld::kPath:
      return absl::StrCat("path ", spec.world_seed.value_or(spec.seed), " ", spec.look_alike, " ",
                          spec.poses, spec.imu.file.empty() ? "" : " ", spec.imu.file);
    case SimulatedWorld::kFloor:
      return absl::StrCat("floor ", spec.world_seed.value_or(spec.seed), " ", spec.rooms_x, " ",
                          spec.rooms_z, " ", spec.look_alike);
  }
  return "";
}

}  // namespace corbslam

#include "services/simulation/sequence/simulation_spec.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
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

absl::Status ValidateWorld(const SimulationSpec& spec) {
  if (spec.world == SimulatedWorld::kPath && spec.poses.empty()) {
    return Refuse("poses", "", "a file of poses to build the world along");
  }
  if (spec.world != SimulatedWorld::kPath && !(spec.poses.empty() && spec.times.empty())) {
    return Refuse("poses", spec.poses, "the world path");
  }
  RETURN_IF_ERROR(Require("length", spec.length_m, 40, 100'000));
  RETURN_IF_ERROR(Require("hills", spec.hills_m, 0, 20));
  RETURN_IF_ERROR(Require("camera_height", spec.camera_height_m, 0.3, 5));
  RETURN_IF_ERROR(Require("rooms", spec.rooms_x, 1, 50));
  RETURN_IF_ERROR(Require("rooms", spec.rooms_z, 1, 50));
  return Require("moving_cars", spec.moving_cars, 0, 10'000);
}

absl::Status ValidateRobot(const SimulationSpec& spec) {
  if (spec.rate_hz != 0) RETURN_IF_ERROR(Require("rate", spec.rate_hz, 0.1, 1000));
  RETURN_IF_ERROR(Require("picture_scale", spec.picture_scale, 0.1, 4));
  RETURN_IF_ERROR(Require("phase", spec.phase, 0, 1));
  RETURN_IF_ERROR(Require("start_s", spec.start_s, 0, 4e9));
  RETURN_IF_ERROR(Require("blackout", spec.blackout.from_s, 0, 1e6));
  RETURN_IF_ERROR(Require("blackout", spec.blackout.duration_s, 0, 1e6));
  if (!spec.kidnap.has_value()) return absl::OkStatus();
  RETURN_IF_ERROR(Require("kidnap", spec.kidnap->at_s, 0, 1e6));
  return Require("kidnap", spec.kidnap->to_s, 0, 1e6);
}

absl::Status ValidateEvents(const SimulationSpec& spec) {
  for (const double seconds :
       {spec.beginning.dark_s, spec.beginning.blurred_s, spec.beginning.still_s}) {
    RETURN_IF_ERROR(Require("beginning", seconds, 0, 1e6));
  }
  RETURN_IF_ERROR(Require("hand", spec.hand.from_s, 0, 1e6));
  RETURN_IF_ERROR(Require("hand", spec.hand.duration_s, 0, 1e6));
  double before_s = 0;
  for (const ExposureStep& step : spec.exposure_steps) {
    RETURN_IF_ERROR(Require("exposure_steps", step.at_s, before_s, 1e6));
    RETURN_IF_ERROR(Require("exposure_steps", step.factor, 0.001, 1000));
    before_s = step.at_s;
  }
  return Require("exposure_ramp_s", spec.exposure_ramp_s, 0, 1e6);
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

absl::Status ValidatePictures(const SimulationSpec& spec) {
  if (const absl::Status status = Validate(spec.lens); !status.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("simulation option ", status.message()));
  }
  RETURN_IF_ERROR(Require("shutter_s", spec.shutter_s, 0, 1));
  RETURN_IF_ERROR(Require("rolling_shutter_ms", spec.rolling_shutter_ms, 0, 100));
  RETURN_IF_ERROR(Require("epipolar_error_px", spec.epipolar_error_px, -20, 20));
  RETURN_IF_ERROR(Require("disparity_error_px", spec.disparity_error_px, -20, 20));
  RETURN_IF_ERROR(Require("scale_error", spec.scale_error, -0.5, 0.5));
  RETURN_IF_ERROR(Require("truth_error_m", spec.truth_error_m, 0, 10));
  RETURN_IF_ERROR(Require("truth_error_deg", spec.truth_error_deg, 0, 10));
  RETURN_IF_ERROR(Require("depth_noise", spec.depth_noise_m, 0, 1));
  RETURN_IF_ERROR(Require("depth_aside_m", spec.depth_aside_m, -0.5, 0.5));
  if (spec.depth_aside_m != 0 && (spec.pair.has_value() || RigOf(spec) != CameraRig::kRgbd)) {
    return Refuse("depth_aside_m", absl::StrCat(spec.depth_aside_m), "rig=rgbd, which has depth");
  }
  return Require("threads", spec.threads, 1, 256);
}

}  // namespace

CameraRig RigOf(const SimulationSpec& spec) {
  return spec.rig.value_or(spec.world == SimulatedWorld::kFloor ? CameraRig::kRgbd
                                                                : CameraRig::kKitti);
}

absl::Status Validate(const SimulationSpec& spec) {
  RETURN_IF_ERROR(ValidateWorld(spec));
  RETURN_IF_ERROR(ValidateRobot(spec));
  RETURN_IF_ERROR(ValidateEvents(spec));
  RETURN_IF_ERROR(ValidatePair(spec));
  return ValidatePictures(spec);
}

std::string WorldName(const SimulationSpec& spec) {
  switch (spec.world) {
    case SimulatedWorld::kCity:
      return absl::StrCat("city ", spec.seed, " ", spec.world_seed.value_or(spec.seed), " ",
                          spec.length_m, " ", spec.hills_m, " ", spec.look_alike);
    case SimulatedWorld::kPath:
      return absl::StrCat("path ", spec.world_seed.value_or(spec.seed), " ", spec.camera_height_m,
                          " ", spec.look_alike, " ", spec.times, " ", spec.poses);
    case SimulatedWorld::kFloor:
      return absl::StrCat("floor ", spec.world_seed.value_or(spec.seed), " ", spec.rooms_x, " ",
                          spec.rooms_z, " ", spec.look_alike);
  }
  return "";
}

}  // namespace corbslam

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

}  // namespace

CameraRig RigOf(const SimulationSpec& spec) {
  return spec.rig.value_or(spec.world == SimulatedWorld::kFloor ? CameraRig::kRgbd
                                                                : CameraRig::kKitti);
}

absl::Status Validate(const SimulationSpec& spec) {
  RETURN_IF_ERROR(ValidateNumbers(spec));
  RETURN_IF_ERROR(ValidatePoses(spec));
  RETURN_IF_ERROR(ValidatePair(spec));
  return ValidateDepth(spec);
}

std::string WorldName(const SimulationSpec& spec) {
  switch (spec.world) {
    case SimulatedWorld::kCity:
      return absl::StrCat("city ", spec.seed, " ", spec.world_seed.value_or(spec.seed), " ",
                          spec.length_m, " ", spec.look_alike);
    case SimulatedWorld::kPath:
      return absl::StrCat("path ", spec.world_seed.value_or(spec.seed), " ", spec.look_alike, " ",
                          spec.poses);
    case SimulatedWorld::kFloor:
      return absl::StrCat("floor ", spec.world_seed.value_or(spec.seed), " ", spec.rooms_x, " ",
                          spec.rooms_z, " ", spec.look_alike);
  }
  return "";
}

}  // namespace corbslam

#include "services/simulation/sequence/simulation_options.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "services/simulation/sequence/event_options.h"
#include "services/simulation/sequence/option_kinds.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

using Option = SimulationOption;

constexpr std::pair<absl::string_view, SimulatedWorld> kWorlds[] = {
    {"city", SimulatedWorld::kCity},
    {"path", SimulatedWorld::kPath},
    {"floor", SimulatedWorld::kFloor}};
constexpr std::pair<absl::string_view, CameraRig> kRigs[] = {
    {"kitti", CameraRig::kKitti}, {"euroc", CameraRig::kEuroc}, {"rgbd", CameraRig::kRgbd}};
constexpr std::pair<absl::string_view, FloorMotion> kMotions[] = {{"walk", FloorMotion::kWalk},
                                                                  {"fly", FloorMotion::kFly}};

std::vector<Option> WorldOptions() {
  using Spec = SimulationSpec;
  return {Whole<uint64_t>("seed", [](Spec& s) -> uint64_t& { return s.seed; }),
          {"world", "a whole number",
           [](absl::string_view value, Spec& spec) {
             return absl::SimpleAtoi(value, &spec.world_seed.emplace());
           },
           [](const Spec& spec) {
             return spec.world_seed.has_value() ? absl::StrCat(*spec.world_seed) : "";
           }},
          Real("length", [](Spec& s) -> double& { return s.length_m; }),
          Real("hills", [](Spec& s) -> double& { return s.hills_m; }),
          Text("poses", [](Spec& s) -> std::string& { return s.poses; }),
          Text("times", [](Spec& s) -> std::string& { return s.times; }),
          Real("camera_height", [](Spec& s) -> double& { return s.camera_height_m; }),
          {"rooms", "COLUMNSxROWS, for example 4x3",
           [](absl::string_view value, Spec& spec) {
             const std::pair<absl::string_view, absl::string_view> parts =
                 absl::StrSplit(value, absl::MaxSplits('x', 1));
             return absl::SimpleAtoi(parts.first, &spec.rooms_x) &&
                    absl::SimpleAtoi(parts.second, &spec.rooms_z);
           },
           [](const Spec& spec) { return absl::StrCat(spec.rooms_x, "x", spec.rooms_z); }},
          Flag("look_alike", [](Spec& s) -> bool& { return s.look_alike; }),
          Whole<int>("moving_cars", [](Spec& s) -> int& { return s.moving_cars; })};
}

std::vector<Option> RobotOptions() {
  using Spec = SimulationSpec;
  return {
      {"rig", "kitti, euroc, rgbd or a rig file",
       [](absl::string_view value, Spec& spec) {
         spec.pair.reset();
         return FindChoice(kRigs, value, spec.rig.emplace());
       },
       [](const Spec& spec) {
         if (spec.pair.has_value()) return spec.pair->file;
         return spec.rig ? NameOf(kRigs, *spec.rig) : "";
       }},
      {"motion", "walk or fly",
       [](absl::string_view value, Spec& spec) { return FindChoice(kMotions, value, spec.motion); },
       [](const Spec& spec) { return NameOf(kMotions, spec.motion); }},
      Real("rate", [](Spec& s) -> double& { return s.rate_hz; }),
      Real("picture_scale", [](Spec& s) -> double& { return s.picture_scale; }),
      Real("phase", [](Spec& s) -> double& { return s.phase; }),
      Flag("turned", [](Spec& s) -> bool& { return s.turned; }),
      Real("start_s", [](Spec& s) -> double& { return s.start_s; }),
      {"blackout", "FROM:DURATION in seconds",
       [](absl::string_view value, Spec& spec) {
         return ParsePair(value, spec.blackout.from_s, spec.blackout.duration_s);
       },
       [](const Spec& spec) {
         return absl::StrCat(FormatReal(spec.blackout.from_s), ":",
                             FormatReal(spec.blackout.duration_s));
       }},
      {"kidnap", "AT:TO in seconds",
       [](absl::string_view value, Spec& spec) {
         Kidnap& kidnap = spec.kidnap.emplace();
         return ParsePair(value, kidnap.at_s, kidnap.to_s);
       },
       [](const Spec& spec) {
         return spec.kidnap.has_value() ? absl::StrCat(FormatReal(spec.kidnap->at_s), ":",
                                                       FormatReal(spec.kidnap->to_s))
                                        : "";
       }}};
}

std::vector<Option> PictureOptions() {
  using Spec = SimulationSpec;
  return {Real("exposure", [](Spec& s) -> double& { return s.lens.exposure; }),
          Real("exposure_drift", [](Spec& s) -> double& { return s.lens.exposure_drift; }),
          Real("lens_gamma", [](Spec& s) -> double& { return s.lens.gamma; }),
          Real("vignetting", [](Spec& s) -> double& { return s.lens.vignetting; }),
          Real("blur_px", [](Spec& s) -> double& { return s.lens.blur_px; }),
          Real("read_noise", [](Spec& s) -> double& { return s.lens.read_noise; }),
          Real("shot_noise", [](Spec& s) -> double& { return s.lens.shot_noise; }),
          Whole<int>("motion_blur", [](Spec& s) -> int& { return s.lens.motion_blur_samples; }),
          Real("shutter_s", [](Spec& s) -> double& { return s.shutter_s; }),
          Real("rolling_shutter_ms", [](Spec& s) -> double& { return s.rolling_shutter_ms; }),
          Whole<uint64_t>("noise_seed", [](Spec& s) -> uint64_t& { return s.lens.noise_seed; }),
          Real("epipolar_error_px", [](Spec& s) -> double& { return s.epipolar_error_px; }),
          Real("disparity_error_px", [](Spec& s) -> double& { return s.disparity_error_px; }),
          Real("scale_error", [](Spec& s) -> double& { return s.scale_error; }),
          Real("depth_noise", [](Spec& s) -> double& { return s.depth_noise_m; }),
          Real("depth_aside_m", [](Spec& s) -> double& { return s.depth_aside_m; }),
          Real("truth_error_m", [](Spec& s) -> double& { return s.truth_error_m; }),
          Real("truth_error_deg", [](Spec& s) -> double& { return s.truth_error_deg; }),
          Whole<int>("threads", [](Spec& s) -> int& { return s.threads; })};
}

const std::vector<Option>& Options() {
  static const auto& options = *[] {
    auto* all = new std::vector<Option>(WorldOptions());
    for (const std::vector<Option>& group : {RobotOptions(), EventOptions(), PictureOptions()}) {
      all->insert(all->end(), group.begin(), group.end());
    }
    return all;
  }();
  return options;
}

const Option* FindOption(absl::string_view key) {
  const auto found = std::find_if(Options().begin(), Options().end(),
                                  [&](const Option& option) { return option.name == key; });
  return found == Options().end() ? nullptr : &*found;
}

}  // namespace

absl::StatusOr<SimulatedWorld> ParseSimulatedWorld(absl::string_view name) {
  SimulatedWorld world = SimulatedWorld::kCity;
  if (FindChoice(kWorlds, name, world)) return world;
  return absl::InvalidArgumentError(
      absl::StrCat("unknown simulated world '", name, "': known are ", ListNames(kWorlds)));
}

absl::string_view FormatSimulatedWorld(SimulatedWorld world) {
  for (const auto& [name, known] : kWorlds) {
    if (known == world) return name;
  }
  return "";
}

bool IsSimulationOption(absl::string_view key) { return FindOption(key) != nullptr; }

std::vector<absl::string_view> SimulationOptionNames() {
  std::vector<absl::string_view> names;
  for (const Option& option : Options()) names.push_back(option.name);
  return names;
}

absl::Status ApplySimulationOption(absl::string_view key, absl::string_view value,
                                   SimulationSpec& spec) {
  const Option* option = FindOption(key);
  if (option == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("unknown simulation option '", key, "'"));
  }
  SimulationSpec changed = spec;
  if (!option->parse(value, changed)) {
    return absl::InvalidArgumentError(
        absl::StrCat("simulation option ", key, "=", value, ": wants ", option->wants));
  }
  spec = changed;
  return absl::OkStatus();
}

std::vector<std::pair<std::string, std::string>> FormatSimulationOptions(
    const SimulationSpec& spec) {
  const SimulationSpec plain;
  std::vector<std::pair<std::string, std::string>> texts;
  for (const Option& option : Options()) {
    const std::string text = option.format(spec);
    if (text != option.format(plain)) texts.emplace_back(option.name, text);
  }
  return texts;
}

}  // namespace corbslam

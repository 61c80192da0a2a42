#include "services/simulation/sequence/simulation_options.h"

#include <algorithm>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "services/simulation/sequence/option_kinds.h"
#include "slam/util/named_values.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

using Option = SimulationOption;
using Spec = SimulationSpec;

constexpr NamedValues<SimulatedWorld, 3> kWorlds = {{{"city", SimulatedWorld::kCity},
                                                     {"path", SimulatedWorld::kPath},
                                                     {"floor", SimulatedWorld::kFloor}}};
constexpr NamedValues<CameraRig, 3> kRigs = {
    {{"kitti", CameraRig::kKitti}, {"euroc", CameraRig::kEuroc}, {"rgbd", CameraRig::kRgbd}}};
constexpr NamedValues<PathSurroundings, 2> kSurroundings = {
    {{"streets", PathSurroundings::kStreets}, {"room", PathSurroundings::kRoom}}};
constexpr NamedValues<FloorMotion, 2> kMotions = {
    {{"walk", FloorMotion::kWalk}, {"fly", FloorMotion::kFly}}};

// "5:0.3/8:1": ',' and '&' end an option.
bool ParseSteps(absl::string_view value, std::vector<ExposureStep>& steps) {
  steps.clear();
  for (const absl::string_view step : absl::StrSplit(value, '/')) {
    ExposureStep& parsed = steps.emplace_back();
    if (!ParseNumbers(step, {&parsed.at_s, &parsed.factor})) return false;
  }
  return true;
}

std::string FormatSteps(const std::vector<ExposureStep>& steps) {
  return absl::StrJoin(steps, "/", [](std::string* out, const ExposureStep& step) {
    absl::StrAppend(out, FormatNumbers({step.at_s, step.factor}));
  });
}

Option RoomsOption() {
  return {"rooms",
          "COLUMNSxROWS, for example 4x3",
          [](absl::string_view value, Spec& spec) {
            const std::pair<absl::string_view, absl::string_view> parts =
                absl::StrSplit(value, absl::MaxSplits('x', 1));
            return absl::SimpleAtoi(parts.first, &spec.rooms_x) &&
                   absl::SimpleAtoi(parts.second, &spec.rooms_z);
          },
          [](const Spec& spec) { return absl::StrCat(spec.rooms_x, "x", spec.rooms_z); },
          [](const Spec& spec) {
            return std::vector<double>{static_cast<double>(spec.rooms_x),
                                       static_cast<double>(spec.rooms_z)};
          },
          1,
          50};
}

std::vector<Option> WorldOptions() {
  return {IntegerOption<uint64_t>("seed", [](Spec& s) -> uint64_t& { return s.seed; }),
          {"world", "a whole number",
           [](absl::string_view value, Spec& spec) {
             return absl::SimpleAtoi(value, &spec.world_seed.emplace());
           },
           [](const Spec& spec) {
             return spec.world_seed.has_value() ? absl::StrCat(*spec.world_seed) : "";
           }},
          Real("length", 40, 100'000, [](Spec& s) -> double& { return s.length_m; }),
          {"poses", "a file",
           [](absl::string_view value, Spec& spec) {
             spec.poses = std::string(value);
             return !value.empty();
           },
           [](const Spec& spec) { return spec.poses; }},
          {"around", "streets or room",
           [](absl::string_view value, Spec& spec) {
             const std::optional<PathSurroundings> around = FindNamed(kSurroundings, value);
             spec.around = around.value_or(spec.around);
             return around.has_value();
           },
           [](const Spec& spec) { return std::string(NameOf(kSurroundings, spec.around)); }},
          RoomsOption(),
          Flag("look_alike", [](Spec& s) -> bool& { return s.look_alike; }),
          IntegerOption("moving_cars", 0, 10'000, [](Spec& s) -> int& { return s.moving_cars; })};
}

Option RigOption() {
  return {"rig", "kitti, euroc, rgbd or a rig file",
          [](absl::string_view value, Spec& spec) {
            spec.pair.reset();
            spec.rig = FindNamed(kRigs, value);
            return spec.rig.has_value();
          },
          [](const Spec& spec) {
            if (spec.pair.has_value()) return spec.pair->file;
            return std::string(spec.rig ? NameOf(kRigs, *spec.rig) : "");
          }};
}

Option RateOption() {
  Option option = Real("rate", 0.1, 1000, [](Spec& s) -> double& { return s.rate_hz; });
  option.numbers = [](const Spec& spec) {  // 0 is the rig's.
    return spec.rate_hz == 0 ? std::vector<double>() : std::vector<double>{spec.rate_hz};
  };
  return option;
}

Option KidnapOption() {
  Option option = Seconds("kidnap", "AT:TO in seconds", [](Spec& s) -> Numbers {
    Kidnap& kidnap = s.kidnap.has_value() ? *s.kidnap : s.kidnap.emplace();
    return {&kidnap.at_s, &kidnap.to_s};
  });
  option.format = [](const Spec& spec) {
    return spec.kidnap.has_value() ? FormatNumbers({spec.kidnap->at_s, spec.kidnap->to_s}) : "";
  };
  return option;
}

std::vector<Option> RobotOptions() {
  return {RigOption(),
          {"motion", "walk or fly",
           [](absl::string_view value, Spec& spec) {
             const std::optional<FloorMotion> motion = FindNamed(kMotions, value);
             spec.motion = motion.value_or(spec.motion);
             return motion.has_value();
           },
           [](const Spec& spec) { return std::string(NameOf(kMotions, spec.motion)); }},
          RateOption(),
          Real("picture_scale", 0.1, 4, [](Spec& s) -> double& { return s.picture_scale; }),
          Real("phase", 0, 1, [](Spec& s) -> double& { return s.phase; }),
          Flag("turned", [](Spec& s) -> bool& { return s.turned; }),
          Real("start_s", 0, 4e9, [](Spec& s) -> double& { return s.start_s; }),
          Seconds("blackout", "FROM:DURATION in seconds",
                  [](Spec& s) -> Numbers {
                    return {&s.blackout.from_s, &s.blackout.duration_s};
                  }),
          KidnapOption()};
}

std::vector<Option> EventOptions() {
  return {
      Seconds("beginning", "DARK:BLURRED:STILL in seconds",
              [](Spec& s) -> Numbers {
                return {&s.beginning.dark_s, &s.beginning.blurred_s, &s.beginning.still_s};
              }),
      Real("set_off_s", 0, 100, [](Spec& s) -> double& { return s.set_off_s; }),
      Seconds("hand", "FROM:DURATION in seconds",
              [](Spec& s) -> Numbers {
                return {&s.hand.from_s, &s.hand.duration_s};
              }),
      {"exposure_steps", "AT:FACTOR/AT:FACTOR/..., seconds and factors",
       [](absl::string_view value, Spec& spec) { return ParseSteps(value, spec.exposure_steps); },
       [](const Spec& spec) { return FormatSteps(spec.exposure_steps); }}};
}

std::vector<Option> PictureOptions() {
  return {
      Real("exposure", 0.01, 100, [](Spec& s) -> double& { return s.lens.exposure; }),
      Real("exposure_drift", 0, 1, [](Spec& s) -> double& { return s.lens.exposure_drift; }),
      Real("blur_px", 0, 10, [](Spec& s) -> double& { return s.lens.blur_px; }),
      Real("rolling_shutter_ms", 0, 100, [](Spec& s) -> double& { return s.rolling_shutter_ms; }),
      IntegerOption<uint64_t>("noise_seed", [](Spec& s) -> uint64_t& { return s.lens.noise_seed; }),
      Real("epipolar_error_px", -20, 20, [](Spec& s) -> double& { return s.epipolar_error_px; }),
      Real("disparity_error_px", -20, 20, [](Spec& s) -> double& { return s.disparity_error_px; }),
      Real("scale_error", -0.5, 0.5, [](Spec& s) -> double& { return s.scale_error; }),
      Real("depth_aside_m", -0.5, 0.5, [](Spec& s) -> double& { return s.depth_aside_m; }),
      Real("truth_error_m", 0, 10, [](Spec& s) -> double& { return s.truth_error_m; }),
      Real("truth_error_deg", 0, 10, [](Spec& s) -> double& { return s.truth_error_deg; }),
      IntegerOption("threads", 1, 256, [](Spec& s) -> int& { return s.threads; })};
}

const Option* FindOption(absl::string_view key) {
  const std::vector<Option>& options = SimulationOptions();
  const auto found = std::find_if(options.begin(), options.end(),
                                  [&](const Option& option) { return option.name == key; });
  return found == options.end() ? nullptr : &*found;
}

}  // namespace

const std::vector<SimulationOption>& SimulationOptions() {
  static const auto& options = *[] {
    auto* all = new std::vector<SimulationOption>(WorldOptions());
    for (const std::vector<SimulationOption>& group :
         {RobotOptions(), EventOptions(), ImuOptions(), PictureOptions()}) {
      all->insert(all->end(), group.begin(), group.end());
    }
    return all;
  }();
  return options;
}

absl::StatusOr<SimulatedWorld> ParseSimulatedWorld(absl::string_view name) {
  if (const std::optional<SimulatedWorld> world = FindNamed(kWorlds, name)) return *world;
  return absl::InvalidArgumentError(
      absl::StrCat("unknown simulated world '", name, "': known are ", JoinNames(kWorlds, ", ")));
}

bool IsSimulationOption(absl::string_view key) { return FindOption(key) != nullptr; }

std::vector<absl::string_view> SimulationOptionNames() {
  std::vector<absl::string_view> names;
  for (const Option& option : SimulationOptions()) names.push_back(option.name);
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
  for (const Option& option : SimulationOptions()) {
    const std::string text = option.format(spec);
    if (text != option.format(plain)) texts.emplace_back(option.name, text);
  }
  return texts;
}

}  // namespace corbslam

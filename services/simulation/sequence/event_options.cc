#include "services/simulation/sequence/event_options.h"

#include <string>

namespace corbslam {
namespace {

using Spec = SimulationSpec;

std::string FormatPair(double first, double second) {
  return absl::StrCat(FormatReal(first), ":", FormatReal(second));
}

// "5:0.3/8:1": ',' and '&' end an option.
bool ParseSteps(absl::string_view value, std::vector<ExposureStep>& steps) {
  steps.clear();
  for (const absl::string_view step : absl::StrSplit(value, '/')) {
    ExposureStep& parsed = steps.emplace_back();
    if (!ParsePair(step, parsed.at_s, parsed.factor)) return false;
  }
  return true;
}

std::string FormatSteps(const std::vector<ExposureStep>& steps) {
  return absl::StrJoin(steps, "/", [](std::string* out, const ExposureStep& step) {
    absl::StrAppend(out, FormatPair(step.at_s, step.factor));
  });
}

bool ParseBeginning(absl::string_view value, Beginning& beginning) {
  const std::vector<absl::string_view> parts = absl::StrSplit(value, ':');
  return parts.size() == 3 && absl::SimpleAtod(parts[0], &beginning.dark_s) &&
         absl::SimpleAtod(parts[1], &beginning.blurred_s) &&
         absl::SimpleAtod(parts[2], &beginning.still_s);
}

}  // namespace

std::vector<SimulationOption> EventOptions() {
  return {
      {"beginning", "DARK:BLURRED:STILL in seconds",
       [](absl::string_view value, Spec& spec) { return ParseBeginning(value, spec.beginning); },
       [](const Spec& spec) {
         return absl::StrCat(FormatPair(spec.beginning.dark_s, spec.beginning.blurred_s), ":",
                             FormatReal(spec.beginning.still_s));
       }},
      {"hand", "FROM:DURATION in seconds",
       [](absl::string_view value, Spec& spec) {
         return ParsePair(value, spec.hand.from_s, spec.hand.duration_s);
       },
       [](const Spec& spec) { return FormatPair(spec.hand.from_s, spec.hand.duration_s); }},
      {"exposure_steps", "AT:FACTOR/AT:FACTOR/..., seconds and factors",
       [](absl::string_view value, Spec& spec) { return ParseSteps(value, spec.exposure_steps); },
       [](const Spec& spec) { return FormatSteps(spec.exposure_steps); }},
      Real("exposure_ramp_s", [](Spec& s) -> double& { return s.exposure_ramp_s; }),
      Flag("exposure_apart", [](Spec& s) -> bool& { return s.exposure_apart; })};
}

}  // namespace corbslam

// What reads and writes one option of a simulation.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_OPTION_KINDS_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_OPTION_KINDS_H_

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "services/simulation/sequence/simulation_spec.h"
#include "slam/util/text_file.h"

namespace corbslam {

template <typename Choices>
std::string ListNames(const Choices& choices) {
  return absl::StrJoin(choices, ", ", [](std::string* out, const auto& choice) {
    absl::StrAppend(out, choice.first);
  });
}

template <typename Choices, typename Value>
bool FindChoice(const Choices& choices, absl::string_view name, Value& value) {
  for (const auto& [known, choice] : choices) {
    if (known != name) continue;
    value = choice;
    return true;
  }
  return false;
}

template <typename Choices, typename Value>
std::string NameOf(const Choices& choices, Value value) {
  for (const auto& [name, choice] : choices) {
    if (choice == value) return std::string(name);
  }
  return "";
}

// How one option is read and written. Each returns false for a value that it can't take.
struct SimulationOption {
  absl::string_view name;
  absl::string_view wants;
  std::function<bool(absl::string_view, SimulationSpec&)> parse;
  std::function<std::string(const SimulationSpec&)> format;  // Empty: the option is not written.
};

template <typename Field>
using Access = Field& (*)(SimulationSpec&);

// Const access by a field that is reached the same way.
template <typename Field>
Field Get(Access<Field> access, SimulationSpec spec) {
  return access(spec);
}

inline SimulationOption Real(absl::string_view name, Access<double> access) {
  return {name, "a number",
          [access](absl::string_view value, SimulationSpec& spec) {
            return absl::SimpleAtod(value, &access(spec));
          },
          [access](const SimulationSpec& spec) { return FormatReal(Get(access, spec)); }};
}

template <typename Integer>
SimulationOption Whole(absl::string_view name, Access<Integer> access) {
  return {name, "a whole number",
          [access](absl::string_view value, SimulationSpec& spec) {
            return absl::SimpleAtoi(value, &access(spec));
          },
          [access](const SimulationSpec& spec) { return absl::StrCat(Get(access, spec)); }};
}

inline SimulationOption Flag(absl::string_view name, Access<bool> access) {
  return {name, "0 or 1",
          [access](absl::string_view value, SimulationSpec& spec) {
            access(spec) = value != "0";
            return value.empty() || value == "0" || value == "1";
          },
          [access](const SimulationSpec& spec) { return Get(access, spec) ? "1" : "0"; }};
}

inline SimulationOption Text(absl::string_view name, Access<std::string> access) {
  return {name, "a file",
          [access](absl::string_view value, SimulationSpec& spec) {
            access(spec) = std::string(value);
            return !value.empty();
          },
          [access](const SimulationSpec& spec) { return Get(access, spec); }};
}

// Parses "A:B".
inline bool ParsePair(absl::string_view value, double& first, double& second) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(value, absl::MaxSplits(':', 1));
  return absl::SimpleAtod(parts.first, &first) && absl::SimpleAtod(parts.second, &second);
}

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_OPTION_KINDS_H_

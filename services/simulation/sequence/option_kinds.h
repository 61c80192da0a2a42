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

// How one option is read, written and bounded.
struct SimulationOption {
  absl::string_view name;
  absl::string_view wants;
  // Returns false for a value that it can't take.
  std::function<bool(absl::string_view, SimulationSpec&)> parse;
  std::function<std::string(const SimulationSpec&)> format;  // Empty: the option is not written.
  // The option's numbers, each of which must be from `least` to `most`. Absent: any will do.
  std::function<std::vector<double>(const SimulationSpec&)> numbers = {};
  double least = 0;
  double most = 0;
};

template <typename Field>
using Access = Field& (*)(SimulationSpec&);

// Const access by a field that is reached the same way.
template <typename Field>
Field Get(Access<Field> access, SimulationSpec spec) {
  return access(spec);
}

inline SimulationOption Real(absl::string_view name, double least, double most,
                             Access<double> access) {
  return {name,
          "a number",
          [access](absl::string_view value, SimulationSpec& spec) {
            return absl::SimpleAtod(value, &access(spec));
          },
          [access](const SimulationSpec& spec) { return FormatReal(Get(access, spec)); },
          [access](const SimulationSpec& spec) { return std::vector{Get(access, spec)}; },
          least,
          most};
}

// Any whole number that the field holds.
template <typename Integer>
SimulationOption IntegerOption(absl::string_view name, Access<Integer> access) {
  return {name, "a whole number",
          [access](absl::string_view value, SimulationSpec& spec) {
            return absl::SimpleAtoi(value, &access(spec));
          },
          [access](const SimulationSpec& spec) { return absl::StrCat(Get(access, spec)); }};
}

inline SimulationOption IntegerOption(absl::string_view name, int least, int most,
                                      Access<int> access) {
  SimulationOption option = IntegerOption<int>(name, access);
  option.numbers = [access](const SimulationSpec& spec) {
    return std::vector<double>{static_cast<double>(Get(access, spec))};
  };
  option.least = least;
  option.most = most;
  return option;
}

inline SimulationOption Flag(absl::string_view name, Access<bool> access) {
  return {name, "0 or 1",
          [access](absl::string_view value, SimulationSpec& spec) {
            access(spec) = value != "0";
            return value.empty() || value == "0" || value == "1";
          },
          [access](const SimulationSpec& spec) { return Get(access, spec) ? "1" : "0"; }};
}

using Numbers = std::vector<double*>;

// Parses as many numbers as there are, with ':' between them.
inline bool ParseNumbers(absl::string_view value, const Numbers& numbers) {
  const std::vector<absl::string_view> parts = absl::StrSplit(value, ':');
  if (parts.size() != numbers.size()) return false;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (!absl::SimpleAtod(parts[i], numbers[i])) return false;
  }
  return true;
}

inline std::string FormatNumbers(const std::vector<double>& numbers) {
  return absl::StrJoin(numbers, ":", [](std::string* out, double number) {
    absl::StrAppend(out, FormatReal(number));
  });
}

// Seconds, from 0 to 1e6, with ':' between them.
inline SimulationOption Seconds(absl::string_view name, absl::string_view wants,
                                Numbers (*access)(SimulationSpec&)) {
  const auto numbers = [access](SimulationSpec spec) {
    std::vector<double> values;
    for (const double* number : access(spec)) values.push_back(*number);
    return values;
  };
  return {name,
          wants,
          [access](absl::string_view value, SimulationSpec& spec) {
            return ParseNumbers(value, access(spec));
          },
          [numbers](const SimulationSpec& spec) { return FormatNumbers(numbers(spec)); },
          numbers,
          0,
          1e6};
}

std::vector<SimulationOption> ImuOptions();

// All options, in the order in which they are written.
const std::vector<SimulationOption>& SimulationOptions();

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_OPTION_KINDS_H_

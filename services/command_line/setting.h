// A program's settings, a row for each: its name, what it may be, its default and what people are
// told of it. The flag, the variable of the environment, the line of the file of --config,
// --print-config and the manual follow from the row, and what is given anywhere is read by it.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_SETTING_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_SETTING_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "slam/util/named_values.h"
#include "slam/util/number_range.h"

namespace corbslam::services {

struct SettingForm {
  // Of a number.
  NumberRange in = {};
  // What --help calls the value; nullptr: by its type.
  const char* unit = nullptr;
  // --help-all alone shows it.
  bool rare = false;
  bool required = false;
  // Of a list: one text may have several values, with this between them; 0: none has.
  char delimiter = 0;
};

inline constexpr SettingForm kRare = {.rare = true};
inline constexpr SettingForm kRequired = {.required = true};
constexpr SettingForm Within(double least, double most) { return {.in = {least, most}}; }
constexpr SettingForm RareWithin(double least, double most) {
  return {.in = {least, most}, .rare = true};
}

// Bounds of a number of bytes, which is written as 500MB, 0.5GiB or 4096 (1 KB is 1024).
inline constexpr uint64_t kMostBytes = uint64_t{1} << 50;  // More has no computer.
constexpr NumberRange Bytes(uint64_t least, uint64_t most = kMostBytes,
                            const char* zero = nullptr) {
  return {static_cast<double>(least), static_cast<double>(most), zero, true};
}

// Of some values with names, the one that is chosen.
struct ChosenValue {
  // Returns what is wrong with a name; empty if nothing.
  std::function<std::string(const std::string&)> read;
  std::string now;
  std::string names;  // With | between them.
};
// The place, of a value or of an optional one, must outlive what is returned.
template <typename Value, size_t kCount, typename Place>
ChosenValue OneOf(const NamedValues<Value, kCount>& table, Place* place) {
  std::string now;
  if constexpr (std::is_same_v<Place, Value>) now = NameOf(table, *place);
  const auto read = [place, &table](const std::string& name) -> std::string {
    const std::optional<Value> value = FindNamed(table, name);
    if (!value.has_value()) return "must be one of " + JoinNames(table, ", ");
    *place = *value;
    return "";
  };
  return {read, now, JoinNames(table, "|")};
}
ChosenValue OneOf(const std::string& yes, const std::string& no, bool* place);

struct Setting {
  using Place = std::variant<bool*, int*, uint64_t*, double*, std::string*, absl::Duration*,
                             std::optional<uint64_t>*, std::optional<double>*,
                             std::vector<std::string>*, ChosenValue>;

  std::string flag;  // With its dashes; a name without any is of a place on the command line.
  // Where the value goes. What stands there is the default. It must outlive the parsing.
  Place place;
  std::string text;
  SettingForm form = {};
};

// Returns how an error names a value that was given: is "7", cut after 80 bytes.
std::string Given(absl::string_view text);

// The name of the check of an option that reads its own values: nothing else need look at them.
inline constexpr char kReadsItself[] = "reads itself";

// Reads a value from anywhere into the setting's place, and returns what is wrong with it, such as
// "is "7", must be 8 to 10000000, or 0 for no bound"; empty if nothing. A list or a switch is read
// by the command line alone.
std::string ReadSetting(const Setting& setting, const std::string& value);

// Adds the flags.
void AddSettings(CLI::App& app, const std::vector<Setting>& settings);
CLI::Option* AddSetting(CLI::App& app, const Setting& setting);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_SETTING_H_

#include "services/command_line/setting.h"

#include <cmath>
#include <limits>

#include "absl/algorithm/container.h"
#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "services/command_line/help_formatter.h"

namespace corbslam::services {
namespace {

template <typename T>
struct IsOptional : std::false_type {};
template <typename T>
struct IsOptional<std::optional<T>> : std::true_type {};

std::string Refused(absl::string_view text, absl::string_view kind, const NumberRange& in,
                    bool is_integer) {
  return absl::StrCat(Given(text), ", must be ", kind, DescribeRange(in, is_integer));
}

// C's functions, which CLI11 hands numbers to, take a sign before what has none, octal and
// hexadecimal digits, and the nearest number that there is for one that there isn't.
template <typename Number>
std::string ReadInteger(absl::string_view text, const NumberRange& in, Number& place) {
  if (text.empty() || !absl::c_all_of(text, absl::ascii_isdigit)) {
    return Refused(text, "a whole number, ", in, true);
  }
  uint64_t number = 0;
  const bool fits = absl::SimpleAtoi(text, &number) &&
                    number <= static_cast<uint64_t>(std::numeric_limits<Number>::max());
  if (!fits && std::isinf(in.most)) return Given(text) + ", which is too large a number";
  if (!fits || !in.Contains(static_cast<double>(number))) return Refused(text, "", in, true);
  place = static_cast<Number>(number);
  return "";
}

std::string ReadReal(absl::string_view text, const NumberRange& in, double& place) {
  double number = 0;
  const bool is_number = !text.empty() && !absl::ascii_isspace(text.front()) &&
                         !absl::ascii_isspace(text.back()) && absl::SimpleAtod(text, &number);
  if (!is_number || !std::isfinite(number)) return Refused(text, "a finite number, ", in, false);
  if (!in.Contains(number)) return Refused(text, "", in, false);
  place = number;
  return "";
}

// Returns how many bytes the unit stands for; nullopt if it is none.
std::optional<double> BytesOf(absl::string_view unit) {
  constexpr absl::string_view kLetters = "bkmgtp";
  const std::string letters = absl::AsciiStrToLower(unit);
  if (letters.empty() || letters == "b") return 1;
  const size_t power = kLetters.find(letters[0]);
  const absl::string_view rest = absl::string_view(letters).substr(1);
  if (power == absl::string_view::npos || power == 0) return std::nullopt;
  if (!rest.empty() && rest != "b" && rest != "ib") return std::nullopt;
  return std::ldexp(1.0, 10 * static_cast<int>(power));
}

std::string ReadBytes(absl::string_view text, const NumberRange& in, uint64_t& place) {
  const size_t end = text.find_first_not_of("0123456789.");
  const absl::string_view digits = text.substr(0, end);
  const std::optional<double> unit =
      BytesOf(end == absl::string_view::npos ? "" : absl::StripAsciiWhitespace(text.substr(end)));
  double number = 0;
  if (digits.empty() || !unit.has_value() || !absl::SimpleAtod(digits, &number)) {
    return Given(text) + ", must be a number of bytes, as 500MB or 0.5GB";
  }
  if (!in.Contains(number * *unit)) return Refused(text, "", in, true);
  place = static_cast<uint64_t>(std::llround(number * *unit));
  return "";
}

std::string ReadDuration(absl::string_view text, absl::Duration& place) {
  absl::Duration duration;
  if (!absl::ParseDuration(text, &duration) || duration < absl::Seconds(1) ||
      duration == absl::InfiniteDuration()) {
    return Given(text) + ", must be at least 1s, as 90m or 720h";
  }
  place = duration;
  return "";
}

template <typename Value>
std::string ReadValue(absl::string_view text, const NumberRange& in, Value& place) {
  if constexpr (IsOptional<Value>()) {
    typename Value::value_type value = {};
    std::string wrong = ReadValue(text, in, value);
    if (wrong.empty()) place = value;
    return wrong;
  } else if constexpr (std::is_same_v<Value, double>) {
    return ReadReal(text, in, place);
  } else if constexpr (std::is_same_v<Value, absl::Duration>) {
    return ReadDuration(text, place);
  } else if constexpr (std::is_same_v<Value, std::string>) {
    place = std::string(text);
    return "";
  } else {
    if constexpr (std::is_same_v<Value, uint64_t>) {
      if (in.is_bytes) return ReadBytes(text, in, place);
    }
    return ReadInteger(text, in, place);
  }
}

template <typename Value>
const char* TypeOf(bool is_bytes) {
  if constexpr (IsOptional<Value>()) return TypeOf<typename Value::value_type>(is_bytes);
  if (std::is_same_v<Value, double>) return "FLOAT";
  if (std::is_same_v<Value, absl::Duration>) return "DURATION";
  if (std::is_same_v<Value, int>) return "INT";
  return is_bytes ? "BYTES" : std::is_integral_v<Value> ? "UINT" : "TEXT";
}

template <typename Value>
std::string DefaultOf(const Value& now) {
  if constexpr (IsOptional<Value>()) {
    return now.has_value() ? DefaultOf(*now) : "";
  } else if constexpr (std::is_same_v<Value, absl::Duration>) {
    return now == absl::InfiniteDuration() ? "" : absl::FormatDuration(now);
  } else {
    return absl::StrCat(now);
  }
}

// Adds an option of one value.
CLI::Option* AddValue(CLI::App& app, const Setting& setting) {
  const CLI::Validator read([setting](std::string& text) { return ReadSetting(setting, text); },
                            "");
  CLI::Option* option = app.add_option_function<std::string>(
      setting.flag, [](const std::string&) {}, setting.text);
  return option->check(read.name(kReadsItself));
}

template <typename Place>
CLI::Option* Add(CLI::App& app, const Setting& setting, const Place& place) {
  if constexpr (std::is_same_v<Place, ChosenValue>) {
    return AddValue(app, setting)->type_name(place.names)->default_str(place.now);
  } else if constexpr (std::is_same_v<Place, bool*>) {
    return app.add_flag(setting.flag, *place, setting.text);
  } else if constexpr (std::is_same_v<Place, std::vector<std::string>*>) {
    CLI::Option* list = app.add_option(setting.flag, *place, setting.text);
    return setting.form.delimiter == 0 ? list : list->delimiter(setting.form.delimiter);
  } else {
    const char* type = TypeOf<std::remove_pointer_t<Place>>(setting.form.in.is_bytes);
    return AddValue(app, setting)->type_name(type)->default_str(DefaultOf(*place));
  }
}

}  // namespace

std::string Given(absl::string_view text) {
  return absl::StrCat("is \"", absl::CHexEscape(text.substr(0, 80)), "\"");
}

ChosenValue OneOf(const std::string& yes, const std::string& no, bool* place) {
  return {[=](const std::string& name) -> std::string {
            if (name != yes && name != no) return absl::StrCat("must be one of ", yes, ", ", no);
            *place = name == yes;
            return "";
          },
          *place ? yes : no, absl::StrCat(yes, "|", no)};
}

std::string ReadSetting(const Setting& setting, const std::string& value) {
  return std::visit(
      [&](const auto& place) -> std::string {
        using Place = std::decay_t<decltype(place)>;
        if constexpr (std::is_same_v<Place, ChosenValue>) {
          const std::string wrong = place.read(value);
          return wrong.empty() ? "" : absl::StrCat(Given(value), ", ", wrong);
        } else if constexpr (std::is_same_v<Place, bool*> ||
                             std::is_same_v<Place, std::vector<std::string>*>) {
          return "is no single value";
        } else {
          return ReadValue(value, setting.form.in, *place);
        }
      },
      setting.place);
}

CLI::Option* AddSetting(CLI::App& app, const Setting& setting) {
  CLI::Option* option =
      std::visit([&](const auto& place) { return Add(app, setting, place); }, setting.place);
  if (setting.form.unit != nullptr) option->type_name(setting.form.unit);
  if (setting.form.rare) option->group(kRareGroup);
  return option->required(setting.form.required);
}

void AddSettings(CLI::App& app, const std::vector<Setting>& settings) {
  for (const Setting& setting : settings) AddSetting(app, setting);
}

}  // namespace corbslam::services

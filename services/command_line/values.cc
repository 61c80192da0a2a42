#include "services/command_line/values.h"

#include <cstdint>
#include <regex>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "services/command_line/environment.h"
#include "services/command_line/setting.h"

namespace corbslam::services {
namespace {

constexpr char kMayBeEmpty[] = "may be empty";

// Returns a number without the zeros behind it that say nothing.
std::string Plain(const std::string& number) {
  if (!absl::StrContains(number, ".")) return number;
  const std::string plain = number.substr(0, number.find_last_not_of('0') + 1);
  return plain.back() == '.' ? plain.substr(0, plain.size() - 1) : plain;
}

bool HasMark(CLI::Option& option, const char* mark) {
  try {
    return option.get_validator(mark) != nullptr;
  } catch (const CLI::OptionNotFound&) {
    return false;
  }
}

// Returns the option's type without what its checks add.
std::string TypeOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

// Makes the text a number that CLI11 reads as it stands, or returns what is wrong with it.
template <typename Number>
std::string CheckNumber(std::string& text) {
  Number number = 0;
  std::string wrong = ReadSetting({"", &number, ""}, text);
  if (wrong.empty() && std::is_integral_v<Number>) text = absl::StrCat(number);
  return wrong;
}

std::string CheckSwitch(std::string& text) {
  for (const char* word : {"true", "false", "on", "off", "yes", "no", "1", "0"}) {
    if (absl::EqualsIgnoreCase(text, word)) return "";
  }
  return Given(text) + ", must be true or false";
}

std::string CheckNotEmpty(std::string& text) {
  return text.empty() ? "is empty: was a variable not set? Leave the flag out, or give it a value"
                      : "";
}

void CheckValuesOf(CLI::Option& option) {
  if (option.get_expected_max() == 0) {
    if (option.get_configurable()) option.check(CLI::Validator(CheckSwitch, ""));
    return;
  }
  const std::string type = HasMark(option, kReadsItself) ? "" : TypeOf(option);
  if (type == "UINT" || type == "INT") {
    option.transform(CLI::Validator(&CheckNumber<uint64_t>, ""));
  } else if (type == "FLOAT") {
    option.transform(CLI::Validator(&CheckNumber<double>, ""));
  }
  // Goes before the others.
  if (!HasMark(option, kMayBeEmpty)) option.transform(CLI::Validator(CheckNotEmpty, ""));
}

}  // namespace

void CheckEveryValue(CLI::App& app) {
  ForEachOption(app, [](CLI::App&, CLI::Option& option) { CheckValuesOf(option); });
}

std::string Rephrased(const std::string& message) {
  static const auto& range = *new std::regex("^(\\S+): Value (.*) not in range (\\S+) to (\\S+)$");
  static const auto& sayings = *new std::vector<std::pair<std::regex, std::string>>{
      {std::regex("^(\\S+): (.*) not in \\{(.*)\\}$"), "$1: is \"$2\", must be one of $3"},
      {std::regex("^Could not convert: (\\S+) = (.*)$"),
       "$1: is \"$2\", which is no value of it, or too large a number"}};
  std::smatch parts;
  if (std::regex_match(message, parts, range)) {
    return absl::StrCat(parts[1].str(), ": ", Given(parts[2].str()), ", must be ",
                        Plain(parts[3].str()), " to ", Plain(parts[4].str()));
  }
  for (const auto& [theirs, ours] : sayings) {
    if (std::regex_match(message, theirs)) return std::regex_replace(message, theirs, ours);
  }
  return message;
}

CLI::Option* MayBeEmpty(CLI::Option* option) {
  return option->check(CLI::Validator([](std::string&) { return std::string(); }, ""), kMayBeEmpty);
}

}  // namespace corbslam::services

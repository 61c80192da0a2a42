#include "services/command_line/values.h"

#include <cmath>
#include <optional>
#include <regex>

#include "absl/algorithm/container.h"
#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "services/command_line/environment.h"

namespace corbslam::services {
namespace {

constexpr char kMayBeEmpty[] = "may be empty";
constexpr char kUndashed[] = "0123456789.";

std::string Quoted(absl::string_view text) {
  return absl::StrCat("is \"", absl::CHexEscape(text.substr(0, 80)), "\"");
}

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

// CLI11 hands numbers to C's functions, which take a sign before what has none, octal and
// hexadecimal digits, and the nearest number that there is for one that there isn't.
std::string CheckWhole(std::string& text) {
  uint64_t number = 0;
  const bool is_plain = !text.empty() && absl::c_all_of(text, absl::ascii_isdigit);
  if (!is_plain) return Quoted(text) + ", must be a whole number, 0 or more";
  if (!absl::SimpleAtoi(text, &number)) return Quoted(text) + ", which is too large a number";
  text = absl::StrCat(number);
  return "";
}

std::string CheckReal(std::string& text) {
  double number = 0;
  const bool is_number = !text.empty() && !absl::ascii_isspace(text.front()) &&
                         !absl::ascii_isspace(text.back()) && absl::SimpleAtod(text, &number);
  if (!is_number || std::isnan(number)) return Quoted(text) + ", must be a number";
  if (std::isinf(number)) return Quoted(text) + ", must be a finite number";
  return number >= 0 ? "" : Quoted(text) + ", must be 0 or more";
}

std::string CheckSwitch(std::string& text) {
  for (const char* word : {"true", "false", "on", "off", "yes", "no", "1", "0"}) {
    if (absl::EqualsIgnoreCase(text, word)) return "";
  }
  return Quoted(text) + ", must be true or false";
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
  const std::string type = TypeOf(option);
  if (type == "UINT" || type == "INT" || type == "KBPS") {
    option.transform(CLI::Validator(CheckWhole, ""));
  } else if (type == "FLOAT" || type == "METRES") {
    option.transform(CLI::Validator(CheckReal, ""));
  }
  // Goes before the others.
  if (!HasMark(option, kMayBeEmpty)) option.transform(CLI::Validator(CheckNotEmpty, ""));
}

// Returns how many bytes the unit stands for; nullopt if it is none.
std::optional<double> BytesOf(absl::string_view unit) {
  constexpr absl::string_view kLetters = "bkmgtp";
  std::string letters = absl::AsciiStrToLower(unit);
  if (letters.empty() || letters == "b") return 1;
  const size_t power = kLetters.find(letters[0]);
  const absl::string_view rest = absl::string_view(letters).substr(1);
  if (power == absl::string_view::npos || power == 0) return std::nullopt;
  if (!rest.empty() && rest != "b" && rest != "ib") return std::nullopt;
  return std::ldexp(1.0, 10 * static_cast<int>(power));
}

// Returns nullopt for what is no number of bytes.
std::optional<double> ParseBytes(absl::string_view text) {
  const size_t end = text.find_first_not_of(kUndashed);
  const absl::string_view digits = text.substr(0, end);
  const absl::string_view unit =
      end == absl::string_view::npos ? "" : absl::StripAsciiWhitespace(text.substr(end));
  const std::optional<double> factor = BytesOf(unit);
  double number = 0;
  if (digits.empty() || !factor.has_value() || !absl::SimpleAtod(digits, &number)) {
    return std::nullopt;
  }
  return std::isfinite(number) ? std::optional(number * *factor) : std::nullopt;
}

std::string FormatBytes(uint64_t bytes) {
  constexpr const char* kUnits[] = {" bytes", " KiB", " MiB", " GiB", " TiB", " PiB"};
  size_t unit = 0;
  for (; unit + 1 < std::size(kUnits) && bytes >= 1024 && bytes % 1024 == 0; ++unit) bytes /= 1024;
  return absl::StrCat(bytes, kUnits[unit]);
}

std::string ReadBytes(const ByteRange& range, std::string& text) {
  const std::optional<double> bytes = ParseBytes(text);
  if (!bytes.has_value()) return Quoted(text) + ", must be a number of bytes, as 500MB or 0.5GB";
  const bool is_none = range.may_be_0 && *bytes == 0;
  if (!is_none &&
      (*bytes < static_cast<double>(range.least) || *bytes > static_cast<double>(range.most))) {
    return absl::StrCat(Quoted(text), ", must be ", FormatBytes(range.least), " to ",
                        FormatBytes(range.most), range.may_be_0 ? ", or 0 for no bound" : "");
  }
  text = absl::StrCat(static_cast<uint64_t>(std::llround(*bytes)));
  return "";
}

}  // namespace

void CheckEveryValue(CLI::App& app) {
  ForEachOption(app, [](CLI::App&, CLI::Option& option) { CheckValuesOf(option); });
}

std::string InOurWords(const std::string& message) {
  static const auto& range = *new std::regex("^(\\S+): Value (.*) not in range (\\S+) to (\\S+)$");
  static const auto& sayings = *new std::vector<std::pair<std::regex, std::string>>{
      {std::regex("^(\\S+): (.*) not in \\{(.*)\\}$"), "$1: is \"$2\", must be one of $3"},
      {std::regex("^Could not convert: (\\S+) = (.*)$"),
       "$1: is \"$2\", which is no value of it, or too large a number"}};
  std::smatch parts;
  if (std::regex_match(message, parts, range)) {
    return absl::StrCat(parts[1].str(), ": ", Quoted(parts[2].str()), ", must be ",
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

CLI::Validator Choice(std::vector<std::pair<std::string, int>> numbers_of_words) {
  return CLI::Validator(
      [words = std::move(numbers_of_words)](std::string& text) -> std::string {
        for (const auto& [word, number] : words) {
          if (word != text) continue;
          text = absl::StrCat(number);
          return "";
        }
        const std::string all = absl::StrJoin(words, ", ", [](std::string* out, const auto& pair) {
          absl::StrAppend(out, pair.first);
        });
        return absl::StrCat(Quoted(text), ", must be one of ", all);
      },
      "");
}

CLI::Validator BytesWithin(const ByteRange& range) {
  return CLI::Validator([range](std::string& text) { return ReadBytes(range, text); }, "");
}

}  // namespace corbslam::services

#include "slam/util/text_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

constexpr int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr absl::string_view kUtf8Mark = "\xef\xbb\xbf";

// Returns the line without a comment and the space around it.
absl::string_view Content(absl::string_view line) {
  for (size_t at = line.find('#'); at != absl::string_view::npos; at = line.find('#', at + 1)) {
    if (at > 0 && !absl::ascii_isspace(static_cast<unsigned char>(line[at - 1]))) continue;
    line = line.substr(0, at);
    break;
  }
  return absl::StripAsciiWhitespace(line);
}

bool IsUtf16(absl::string_view text) {
  return absl::StartsWith(text, "\xff\xfe") || absl::StartsWith(text, "\xfe\xff");
}

// Uses what lies between two LFs: one line, or several that end with CR.
absl::Status UseLines(absl::string_view text, int& line,
                      const std::function<absl::Status(int, absl::string_view)>& use_line) {
  absl::ConsumeSuffix(&text, "\r");
  for (const absl::string_view part : absl::StrSplit(text, '\r')) {
    const absl::string_view content = Content(part);
    if (!content.empty()) RETURN_IF_ERROR(use_line(line, content));
    ++line;
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status LineError(absl::string_view path, int line, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(path, ":", line, ": ", what));
}

absl::Status ForEachLine(const std::string& path,
                         const std::function<absl::Status(int, absl::string_view)>& use_line) {
  std::ifstream file(path);
  if (!file) return absl::NotFoundError(absl::StrCat("cannot open ", path));
  std::string text;
  int line = 1;
  while (std::getline(file, text)) {
    absl::string_view rest = text;
    if (line == 1) {
      if (IsUtf16(rest)) return LineError(path, 1, "is UTF-16 text: save it as UTF-8");
      absl::ConsumePrefix(&rest, kUtf8Mark);
    }
    RETURN_IF_ERROR(UseLines(rest, line, use_line));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> ParseNumbers(const std::vector<absl::string_view>& fields,
                                                 absl::string_view path, int line) {
  std::vector<double> numbers(fields.size());
  for (size_t i = 0; i < fields.size(); ++i) {
    if (!absl::SimpleAtod(absl::StripAsciiWhitespace(fields[i]), &numbers[i]) ||
        !std::isfinite(numbers[i])) {
      return LineError(path, line, absl::StrCat("field ", i + 1, " is no number: ", fields[i]));
    }
  }
  return numbers;
}

absl::StatusOr<int64_t> ParseSeconds(absl::string_view text) {
  const absl::string_view stripped = absl::StripAsciiWhitespace(text);
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(stripped, absl::MaxSplits('.', 1));
  const bool is_plain = !parts.first.empty() && parts.first.size() <= 10 &&
                        stripped.find_first_not_of("0123456789.") == absl::string_view::npos &&
                        parts.second.find('.') == absl::string_view::npos;
  if (is_plain) {
    // Digits beyond the ninth are below a nanosecond.
    std::string digits(parts.second.substr(0, 9));
    digits.resize(9, '0');
    int64_t seconds = 0;
    int64_t nanoseconds = 0;
    if (absl::SimpleAtoi(parts.first, &seconds) && absl::SimpleAtoi(digits, &nanoseconds) &&
        seconds < 9'000'000'000) {
      return seconds * kNanosecondsPerSecond + nanoseconds;
    }
  }
  double seconds = 0;
  if (!absl::SimpleAtod(stripped, &seconds) || !(std::abs(seconds) < 9e9)) {
    return absl::InvalidArgumentError(absl::StrCat("no time in seconds: '", stripped, "'"));
  }
  return std::llround(seconds * static_cast<double>(kNanosecondsPerSecond));
}

std::string FormatSeconds(int64_t timestamp_ns) {
  const uint64_t magnitude_ns = timestamp_ns < 0 ? 0 - static_cast<uint64_t>(timestamp_ns)
                                                 : static_cast<uint64_t>(timestamp_ns);
  return absl::StrFormat("%s%d.%09d", timestamp_ns < 0 ? "-" : "",
                         magnitude_ns / kNanosecondsPerSecond,
                         magnitude_ns % kNanosecondsPerSecond);
}

std::string FormatReal(double number) {
  char text[32];
  const std::to_chars_result end = std::to_chars(std::begin(text), std::end(text), number);
  return std::string(std::begin(text), end.ptr);
}

absl::Status WriteLines(const std::vector<std::string>& lines, const std::string& path) {
  std::string text;
  for (const std::string& line : lines) absl::StrAppend(&text, line, "\n");
  return WriteAtomically(path, text);
}

}  // namespace corbslam

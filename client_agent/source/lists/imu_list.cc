#include "client_agent/source/lists/imu_list.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kImuFields = 7;
constexpr char kImuForm[] =
    "a line has 7 fields: time in ns, angular velocity x, y, z in rad/s, acceleration less gravity "
    "x, y, z in m/s2 (EuRoC's imu0/data.csv)";
// Where more than one sample in so many is out of order, or of another's time, the list as a whole
// is none.
constexpr size_t kOddImuShare = 10;
constexpr int64_t kImuJumpBack_ns = 1'000'000'000;

bool ImuIsBefore(const ImuSample& a, const ImuSample& b) { return a.timestamp_ns < b.timestamp_ns; }

// Returns where one of the words stands first in a heading.
size_t FindFirst(absl::string_view heading, const std::vector<absl::string_view>& words) {
  size_t first = absl::string_view::npos;
  for (const absl::string_view word : words) first = std::min(first, heading.find(word));
  return first;
}

// Looks at the first line, a comment as a rule, for units and an order that are not EuRoC's.
absl::Status CheckHeading(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return absl::OkStatus();
  const std::vector<absl::string_view> fields =
      absl::StrSplit(line, absl::ByAnyChar(",;\t"), absl::SkipEmpty());
  if (fields.size() != kImuFields) return absl::OkStatus();  // Any other comment.
  const std::string heading = absl::AsciiStrToLower(line);
  if (absl::StrContains(heading, "deg")) {
    return LineError(
        path, 1,
        absl::StrCat("the heading says degrees: angular velocities must be in rad/s; ", kImuForm));
  }
  const size_t turning = FindFirst(heading, {"w_", "gyr", "ang", "omega"});
  const size_t force = FindFirst(heading, {"a_rs", "acc", "alpha", "lin"});
  if (turning == absl::string_view::npos || force == absl::string_view::npos || turning < force) {
    return absl::OkStatus();
  }
  return LineError(
      path, 1,
      absl::StrCat("the heading has accelerations before angular velocities: put the gyroscope's "
                   "three fields first; ",
                   kImuForm));
}

absl::Status NoImuTime(const std::string& path, int line, absl::string_view field) {
  return LineError(
      path, line,
      absl::StrCat(
          "field 1 is no time in whole nanoseconds: ", field,
          absl::StrContains(field, '.') ? ". Is it in seconds? Write all its digits, in ns" : ""));
}

// Returns nullopt for a line of headings.
absl::StatusOr<std::optional<ImuSample>> ParseSample(const std::string& path, int line,
                                                     absl::string_view text) {
  std::vector<absl::string_view> fields =
      absl::StrSplit(text, absl::ByAnyChar(",; \t"), absl::SkipEmpty());
  const bool is_heading =
      line == 1 && !fields.empty() && absl::ascii_isalpha(static_cast<unsigned char>(fields[0][0]));
  if (is_heading) return std::nullopt;
  if (fields.size() != kImuFields) {
    return LineError(path, line, absl::StrCat(fields.size(), " fields instead of 7: ", kImuForm));
  }
  ImuSample sample;
  if (!absl::SimpleAtoi(fields[0], &sample.timestamp_ns)) return NoImuTime(path, line, fields[0]);
  if (sample.timestamp_ns < 0) {
    return LineError(path, line, absl::StrCat("the time ", fields[0], " is negative"));
  }
  ASSIGN_OR_RETURN(const std::vector<double> n, ParseNumbers(fields, path, line));
  sample.angular_velocity_rps = {n[1], n[2], n[3]};
  sample.specific_force_mps2 = {n[4], n[5], n[6]};
  return sample;
}

absl::Status TooManyOdd(absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(what, ": that is no list of samples in the order of time, each with its own"));
}

bool MeasureAlike(const ImuSample& a, const ImuSample& b) {
  return a.angular_velocity_rps == b.angular_velocity_rps &&
         a.specific_force_mps2 == b.specific_force_mps2;
}

// Takes each time once.
absl::Status TakeOnce(const std::string& from, ImuSamples& samples, SourceFindings& findings) {
  size_t repeats = 0;
  size_t others = 0;
  int64_t first_ns = 0;
  ImuSamples once;
  for (const ImuSample& sample : samples) {
    if (once.empty() || sample.timestamp_ns != once.back().timestamp_ns) {
      once.push_back(sample);
      continue;
    }
    if (repeats++ == 0) first_ns = sample.timestamp_ns;
    if (!MeasureAlike(sample, once.back())) ++others;
  }
  if (repeats == 0) return absl::OkStatus();
  const std::string what =
      absl::StrCat(from, ": ", repeats, " of ", samples.size(),
                   " samples of the IMU have the time of another, the first at ", first_ns, " ns; ",
                   others, " of them with other values");
  if (repeats * kOddImuShare > samples.size()) return TooManyOdd(what);
  findings.push_back({FindingLevel::kWarning, "imu-times-repeat",
                      absl::StrCat(what, ": the first of each time is taken")});
  samples = std::move(once);
  return absl::OkStatus();
}

}  // namespace

absl::Status PutInOrder(const std::string& from, ImuSamples& samples, SourceFindings& findings) {
  size_t back = 0;
  int64_t latest_ns = 0;
  int64_t first_ns = 0;
  for (const ImuSample& sample : samples) {
    if (sample.timestamp_ns < latest_ns && back++ == 0) first_ns = sample.timestamp_ns;
    latest_ns = std::max(latest_ns, sample.timestamp_ns);
    if (latest_ns - sample.timestamp_ns <= kImuJumpBack_ns) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        from, ": the IMU's time jumps back from ", latest_ns, " to ", sample.timestamp_ns,
        " ns: are these two recordings, or was the clock set? Give the samples of one alone"));
  }
  if (back > 0) {
    const std::string what =
        absl::StrCat(from, ": ", back, " of ", samples.size(),
                     " samples of the IMU are out of order, the first at ", first_ns, " ns");
    if (back * kOddImuShare > samples.size()) return TooManyOdd(what);
    findings.push_back({FindingLevel::kWarning, "imu-out-of-order",
                        absl::StrCat(what, ": they are put in the order of time")});
    std::stable_sort(samples.begin(), samples.end(), ImuIsBefore);
  }
  return TakeOnce(from, samples, findings);
}

absl::StatusOr<ImuSamples> ReadImuLines(const std::string& path) {
  RETURN_IF_ERROR(CheckHeading(path));
  ImuSamples samples;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    ASSIGN_OR_RETURN(const std::optional<ImuSample> sample, ParseSample(path, line, text));
    if (sample.has_value()) samples.push_back(*sample);
    return absl::OkStatus();
  }));
  return samples;
}

absl::StatusOr<ImuSamples> ReadImuList(const std::string& path, SourceRemarks& remarks) {
  ASSIGN_OR_RETURN(ImuSamples samples, ReadImuLines(path));
  if (samples.size() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": lists ", samples.size(), " samples of an IMU: ", kImuForm));
  }
  RETURN_IF_ERROR(PutInOrder(path, samples, remarks.findings));
  return samples;
}

ImuSamples ImuBetween(const ImuSamples& samples, int64_t after_ns, int64_t until_ns) {
  const auto later_than = [](int64_t time_ns, const ImuSample& sample) {
    return time_ns < sample.timestamp_ns;
  };
  const auto earlier_than = [](const ImuSample& sample, int64_t time_ns) {
    return sample.timestamp_ns < time_ns;
  };
  const auto begin = std::upper_bound(samples.begin(), samples.end(), after_ns, later_than);
  auto end = std::lower_bound(begin, samples.end(), until_ns, earlier_than);
  if (end != samples.end() && end->timestamp_ns - until_ns <= kMostAheadOfPicture_ns &&
      (begin == samples.begin() || std::prev(begin)->timestamp_ns < until_ns)) {
    ++end;
  }
  return {begin, end};
}

void ShiftTimes(int64_t by_ns, ImuSamples& samples) {
  for (ImuSample& sample : samples) sample.timestamp_ns += by_ns;
}

std::string FormatImuLine(const ImuSample& sample) {
  std::string line = absl::StrCat(sample.timestamp_ns);
  for (const Eigen::Vector3d* three : {&sample.angular_velocity_rps, &sample.specific_force_mps2}) {
    for (const double number : *three) absl::StrAppend(&line, ",", FormatReal(number));
  }
  return line;
}

}  // namespace corbslam::client_agent

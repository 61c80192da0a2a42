#include "slam/evaluation/pose_rows.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

constexpr absl::string_view kByteOrderMark = "\xef\xbb\xbf";
constexpr double kMaxRotationError = 0.01;
// Times in nanoseconds since 1970 have at least so many digits after 1973. Seconds have ten at
// most.
constexpr size_t kLeastNanosecondDigits = 18;
// The wire takes times up to this, on both sides of 0.
constexpr int64_t kMaxTime_ns = int64_t{1} << 62;

bool IsNumber(absl::string_view text) {
  double ignored = 0;
  return absl::SimpleAtod(text, &ignored);
}

bool IsFinite(const Rigid3d& pose) {
  return pose.translation.allFinite() && pose.rotation.coeffs().allFinite();
}

}  // namespace

void PoseRows::Add(int line, const std::optional<int64_t>& timestamp_ns, const Rigid3d& pose) {
  const bool is_time =
      timestamp_ns.has_value() && *timestamp_ns >= -kMaxTime_ns && *timestamp_ns <= kMaxTime_ns;
  if (!is_time || !IsFinite(pose)) return LeaveOut(line);
  if (!rows_.empty() && *timestamp_ns < rows_.back().pose.timestamp_ns) {
    NoteLine(line, out_of_order_);
  }
  rows_.push_back({line, {*timestamp_ns, pose}});
}

void PoseRows::AddNote(const Lines& lines, absl::string_view what,
                       std::vector<std::string>& notes) const {
  if (lines.count == 0) return;
  notes.push_back(absl::StrCat(path_, ": ", lines.count, lines.count == 1 ? " row " : " rows ",
                               what, " (the first is ", row_word_, " ", lines.first, ")"));
}

TrajectoryReading PoseRows::Finish() {
  std::stable_sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) {
    return a.pose.timestamp_ns < b.pose.timestamp_ns;
  });
  TrajectoryReading reading;
  Lines repeated;
  for (const Row& row : rows_) {
    const bool is_new = reading.trajectory.empty() ||
                        reading.trajectory.back().timestamp_ns != row.pose.timestamp_ns;
    if (is_new) {
      reading.trajectory.push_back(row.pose);
    } else if (repeated.count++ == 0 || row.line < repeated.first) {
      repeated.first = row.line;
    }
  }
  reading.rows_not_finite = not_finite_.count;
  reading.rows_repeated = repeated.count;
  reading.rows_out_of_order = out_of_order_.count;
  AddNote(not_finite_, "left out: a value is not finite or out of range", reading.notes);
  AddNote(repeated, "left out: an earlier row has the same time", reading.notes);
  AddNote(out_of_order_, "earlier than the row before: sorted by time", reading.notes);
  return reading;
}

absl::Status ForEachRow(const std::string& path,
                        const std::function<void(absl::string_view)>& use_comment,
                        const std::function<absl::Status(const TextRow&)>& use_row) {
  std::ifstream file(path);
  if (!file) return absl::NotFoundError(absl::StrCat("cannot open ", path));
  std::string text;
  bool had_row = false;
  for (int line = 1; std::getline(file, text); ++line) {
    absl::string_view rest = text;
    if (line == 1) absl::ConsumePrefix(&rest, kByteOrderMark);
    rest = absl::StripAsciiWhitespace(rest);
    if (absl::StartsWith(rest, "#")) {
      use_comment(rest);
      continue;
    }
    const absl::string_view values = rest.substr(0, rest.find('#'));
    TextRow row;
    row.line = line;
    row.has_commas = absl::StrContains(values, ',');
    row.fields = absl::StrSplit(values, absl::ByAnyChar(" \t,;"), absl::SkipEmpty());
    if (row.fields.empty()) continue;
    if (!had_row && std::none_of(row.fields.begin(), row.fields.end(), IsNumber)) {
      use_comment(rest);
      continue;
    }
    had_row = true;
    RETURN_IF_ERROR(use_row(row));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> ParseAnyNumbers(const TextRow& row, absl::string_view path) {
  std::vector<double> numbers(row.fields.size());
  for (size_t i = 0; i < row.fields.size(); ++i) {
    if (absl::SimpleAtod(row.fields[i], &numbers[i])) continue;
    return LineError(path, row.line,
                     absl::StrCat("field ", i + 1, " is no number: ", row.fields[i]));
  }
  return numbers;
}

absl::Status WrongCount(const TextRow& row, absl::string_view path, absl::string_view expected) {
  return LineError(path, row.line,
                   absl::StrCat(row.fields.size(), " fields instead of ", expected));
}

absl::StatusOr<std::optional<int64_t>> ParseTime(absl::string_view field, double number,
                                                 absl::string_view path, int line) {
  if (!AllFinite({number})) return std::nullopt;
  int64_t nanoseconds = 0;
  if (field.size() >= kLeastNanosecondDigits && absl::SimpleAtoi(field, &nanoseconds)) {
    return nanoseconds;
  }
  const absl::StatusOr<int64_t> timestamp_ns = ParseSeconds(field);
  if (!timestamp_ns.ok()) return LineError(path, line, timestamp_ns.status().message());
  return *timestamp_ns;
}

absl::StatusOr<Trajectory> AllOf(absl::StatusOr<TrajectoryReading> reading) {
  RETURN_IF_ERROR(reading.status());
  if (reading->rows_not_finite > 0) return absl::InvalidArgumentError(reading->notes.front());
  return std::move(reading->trajectory);
}

bool AllFinite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(),
                     [](double number) { return std::isfinite(number); });
}

absl::StatusOr<Eigen::Quaterniond> RotationFromQuaternion(double w, double x, double y, double z,
                                                          absl::string_view path, int line) {
  const Eigen::Quaterniond rotation(w, x, y, z);
  if (std::abs(rotation.norm() - 1.0) > kMaxRotationError) {
    return LineError(path, line, absl::StrCat("quaternion of length ", rotation.norm()));
  }
  return rotation.normalized();
}

absl::StatusOr<Eigen::Quaterniond> RotationFromMatrix(const Eigen::Matrix3d& matrix,
                                                      absl::string_view path, int line) {
  const double error = (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).norm();
  // The comparison is written so that NaN (from infinite products) fails.
  if (!(error <= kMaxRotationError) || matrix.determinant() < 0) {
    return LineError(path, line, "the matrix holds no rotation");
  }
  return Eigen::Quaterniond(matrix).normalized();
}

}  // namespace corbslam

#include "client_agent/source/lists/timeline.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

// Where more than one time in so many is out of order, the list as a whole is in no order of time.
constexpr size_t kOutOfOrderShare = 10;
constexpr double kShortestInterval_s = 0.0005;
constexpr double kLongestInterval_s = 60;
constexpr double kImprobablyShort_s = 0.002;
constexpr double kImprobablyLong_s = 2;
constexpr double kGap_intervals = 10;
constexpr double kLeastGap_s = 1;
constexpr double kLongGap_s = 5;
constexpr double kLongGap_intervals = 1.5;

double ToSeconds(int64_t ns) { return 1e-9 * static_cast<double>(ns); }

std::string TimeText(const ListedTime& time) {
  return absl::StrCat(FormatSeconds(time.timestamp_ns), " s");
}

absl::Status Repeats(const std::string& path, const ListedTime& before, const ListedTime& time) {
  return LineError(path, time.line,
                   absl::StrCat("the time ", TimeText(time), " stands in line ", before.line,
                                " too: each picture needs a time of its own"));
}

// Leaves out what is out of order, with one warning.
absl::Status TellOutOfOrder(const std::string& path, const std::vector<ListedTime>& times,
                            const std::vector<size_t>& out_of_order, Timeline& timeline) {
  if (out_of_order.empty()) return absl::OkStatus();
  const ListedTime& first = times[out_of_order.front()];
  const std::string what =
      absl::StrCat(out_of_order.size(), " of ", times.size(), " times do not grow, the first in ",
                   path, ":", first.line, " (", TimeText(first), ")");
  if (out_of_order.size() * kOutOfOrderShare > times.size()) {
    return absl::InvalidArgumentError(absl::StrCat(what, ": put the list in the order of time"));
  }
  timeline.remarks.left_out.push_back(what);
  timeline.remarks.findings.push_back({FindingLevel::kWarning, "times-out-of-order",
                                       absl::StrCat(what, ": these frames are left out")});
  return absl::OkStatus();
}

void TellJumpBack(const std::string& path, const ListedTime& before, const ListedTime& time,
                  Timeline& timeline) {
  timeline.remarks.findings.push_back(
      {FindingLevel::kWarning, "times-jump-back",
       absl::StrCat(path, ":", time.line, ": the time jumps back from ", TimeText(before), " to ",
                    TimeText(time), ": a new local map begins here")});
}

}  // namespace

absl::StatusOr<Timeline> BuildTimeline(const std::string& path,
                                       const std::vector<ListedTime>& times) {
  Timeline timeline;
  std::vector<size_t> out_of_order;
  int drive = 0;
  for (size_t i = 0; i < times.size(); ++i) {
    const ListedTime& time = times[i];
    if (time.timestamp_ns < 0) {
      return LineError(path, time.line, absl::StrCat("the time ", TimeText(time), " is negative"));
    }
    if (!timeline.kept.empty()) {
      const ListedTime& before = times[timeline.kept.back()];
      const int64_t step_ns = time.timestamp_ns - before.timestamp_ns;
      if (step_ns == 0) return Repeats(path, before, time);
      if (step_ns < -kJumpBack_ns) {
        TellJumpBack(path, before, time, timeline);
        ++drive;
      } else if (step_ns < 0) {
        out_of_order.push_back(i);
        continue;
      }
    }
    timeline.kept.push_back(i);
    timeline.drive.push_back(drive);
  }
  RETURN_IF_ERROR(TellOutOfOrder(path, times, out_of_order, timeline));
  return timeline;
}

namespace {

std::vector<double> IntervalsOf(const std::vector<int64_t>& times_ns) {
  std::vector<double> intervals_s;
  for (size_t i = 1; i < times_ns.size(); ++i) {
    if (times_ns[i] > times_ns[i - 1]) {
      intervals_s.push_back(ToSeconds(times_ns[i] - times_ns[i - 1]));
    }
  }
  return intervals_s;
}

// Returns how long the camera was on its way, jumps back aside.
double DurationOf(const std::vector<double>& intervals_s) {
  double sum_s = 0;
  for (const double interval_s : intervals_s) sum_s += interval_s;
  return sum_s;
}

void CountGaps(const std::vector<int64_t>& times_ns, double median_s, TimeStatistics& statistics) {
  // Whatever the rate: behind a long one a camera is elsewhere.
  const double long_s = std::max(kLongGap_s, kLongGap_intervals * median_s);
  const double least_s = std::min(std::max(kLeastGap_s, kGap_intervals * median_s), long_s);
  for (size_t i = 1; i < times_ns.size(); ++i) {
    const double interval_s = ToSeconds(times_ns[i] - times_ns[i - 1]);
    if (interval_s <= least_s) continue;
    ++statistics.gaps;
    if (interval_s <= statistics.longest_gap_s) continue;
    statistics.longest_gap_s = interval_s;
    statistics.longest_gap_frame = i;
  }
}

absl::Status CheckUnit(const std::string& path, double median_s, SourceFindings& findings) {
  const std::string text =
      absl::StrFormat("%s: the median interval between frames is %.6g s", path, median_s);
  if (median_s < kShortestInterval_s || median_s > kLongestInterval_s) {
    return absl::InvalidArgumentError(absl::StrCat(
        text, ", must be in [", kShortestInterval_s, ", ", kLongestInterval_s,
        "]: its times are in another unit (seconds are wanted in lists of KITTI and TUM, "
        "nanoseconds in EuRoC's)"));
  }
  if (median_s < kImprobablyShort_s || median_s > kImprobablyLong_s) {
    findings.push_back(
        {FindingLevel::kWarning, "times-odd-rate",
         absl::StrFormat("%s, %.3g frames/s: are its times in another unit?", text, 1 / median_s)});
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<TimeStatistics> MeasureTimes(const std::string& path,
                                            const std::vector<int64_t>& times_ns,
                                            SourceFindings& findings) {
  TimeStatistics statistics;
  const std::vector<double> intervals_s = IntervalsOf(times_ns);
  if (intervals_s.empty()) return statistics;
  const double median_s = Median(intervals_s);
  RETURN_IF_ERROR(CheckUnit(path, median_s, findings));
  statistics.rate_hz = 1 / median_s;
  statistics.duration_s = DurationOf(intervals_s);
  CountGaps(times_ns, median_s, statistics);
  if (statistics.longest_gap_s > kLongGap_s) {
    findings.push_back(
        {FindingLevel::kWarning, "times-gap",
         absl::StrFormat("%s: no frame for %.1f s before frame %d (%d gaps in all): tracking is "
                         "lost there unless the camera stood still",
                         path, statistics.longest_gap_s, statistics.longest_gap_frame,
                         statistics.gaps)});
  }
  return statistics;
}

}  // namespace corbslam::client_agent

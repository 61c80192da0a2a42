#include "services/programs/robot/source_pace.h"

#include <glog/logging.h>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kNotWorthALine = absl::Seconds(1);
constexpr int kLeastShare = 10;

}  // namespace

void SourcePace::OnFrame(absl::Time came, absl::Duration held) {
  if (frames_++ == 0) first_ = came;
  last_ = came;
  held_ += held;
}

absl::Duration SourcePace::frame_time() const {
  return frames_ < 2 ? absl::ZeroDuration() : (last_ - first_) / (frames_ - 1);
}

bool SourcePace::IsTooSlow() const {
  return held_ > kNotWorthALine && held_ * kLeastShare > last_ - first_;
}

std::string DescribeSlowSource(const SourcePace& pace, std::optional<double> interval_s) {
  std::string text = absl::StrFormat(
      "the source itself is too slow for --pace sensor: it gives a "
      "frame each %.0f ms",
      absl::ToDoubleMilliseconds(pace.frame_time()));
  if (interval_s.has_value()) {
    absl::StrAppendFormat(&text, ", by the frames' times it should be each %.0f ms",
                          1e3 * *interval_s);
  }
  return absl::StrFormat(
      "%s. The robot's clock waited for it, %.1f s so far, and dropped no frame for that; take "
      "--pace max, or a faster disk or processor for the source",
      text, absl::ToDoubleSeconds(pace.held()));
}

void SlowSourceLog::Tell(const SourcePace& pace, std::optional<double> interval_s, absl::Time now) {
  if (!pace.IsTooSlow() || !reminder_.IsDue(now)) return;
  LOG(WARNING) << DescribeSlowSource(pace, interval_s);
}

}  // namespace corbslam::services

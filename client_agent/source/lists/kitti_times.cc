#include "client_agent/source/lists/kitti_times.h"

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

absl::StatusOr<int64_t> ParseTime(absl::string_view text) {
  if (!absl::StrContains(text, ':')) return ParseSeconds(text);
  absl::Time time;
  std::string error;
  if (!absl::ParseTime("%Y-%m-%d %H:%M:%E*S", text, &time, &error)) {
    return absl::InvalidArgumentError(absl::StrCat("no date and time: '", text, "': ", error));
  }
  return absl::ToUnixNanos(time);
}

}  // namespace

absl::StatusOr<std::vector<ListedTime>> ReadKittiTimes(const std::string& path) {
  std::vector<ListedTime> times;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const absl::StatusOr<int64_t> time_ns = ParseTime(text);
    if (!time_ns.ok()) return LineError(path, line, time_ns.status().message());
    times.push_back({*time_ns, line});
    return absl::OkStatus();
  }));
  if (times.empty()) return absl::InvalidArgumentError(absl::StrCat(path, ": no times"));
  return times;
}

}  // namespace corbslam::client_agent

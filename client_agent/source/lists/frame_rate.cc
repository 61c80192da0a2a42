#include "client_agent/source/lists/frame_rate.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {

std::vector<ListedTime> TimesAtRate(double fps, size_t count) {
  std::vector<ListedTime> times;
  for (size_t i = 0; i < count; ++i) {
    times.push_back({std::llround(1e9 * static_cast<double>(i) / fps), static_cast<int>(i + 1)});
  }
  return times;
}

absl::Status NoTimes(const std::string& path) {
  return absl::NotFoundError(absl::StrCat(
      path, " is not there, and nothing else says when the pictures were taken: say ?fps=RATE"));
}

}  // namespace corbslam::client_agent

#include "slam/util/thread_priority.h"

#include <glog/logging.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

constexpr int kLowest = 19;

}  // namespace

absl::Status LowerThreadPriority(int steps) {
  CHECK_GE(steps, 0) << "to raise a priority takes privileges";
  // Linux keeps a niceness for each thread.
  const auto thread = static_cast<id_t>(gettid());
  const int niceness = std::min(kLowest, getpriority(PRIO_PROCESS, thread) + steps);
  if (setpriority(PRIO_PROCESS, thread, niceness) == 0) return absl::OkStatus();
  return absl::ErrnoToStatus(
      errno, absl::StrCat("a thread's niceness can't be ", niceness,
                          "; permit setpriority where a filter of system calls is in force"));
}

void StepBehindRobots(int steps, absl::string_view what) {
  const absl::Status lowered = LowerThreadPriority(steps);
  LOG_IF(WARNING, !lowered.ok()) << what << " may hold up robots: " << lowered;
}

}  // namespace corbslam

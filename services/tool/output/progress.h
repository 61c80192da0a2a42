// Shows how far a long command is, on standard error.
#ifndef CORBSLAM_SERVICES_TOOL_OUTPUT_PROGRESS_H_
#define CORBSLAM_SERVICES_TOOL_OUTPUT_PROGRESS_H_

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace corbslam::services {

struct ProgressOptions {
  std::FILE* out = stderr;
  bool is_terminal = false;
  bool is_quiet = false;  // Nothing is shown.
  std::function<absl::Time()> clock = &absl::Now;
};
// Returns what the command that runs is to show: nothing with --json (result.h).
ProgressOptions DefaultProgress();

// On a terminal one line that is written over, at most once a second, and that is gone at the end.
// Elsewhere a line "progress: ..." every ten seconds, the first one ten seconds after the start, so
// that short work says nothing. Thread-safe.
class ProgressLine {
 public:
  explicit ProgressLine(ProgressOptions options = DefaultProgress());
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // Shows the text if it is time for it. Cheap otherwise, apart from making the text.
  void Tell(const std::string& text);

 private:
  const ProgressOptions options_;
  absl::Mutex mutex_;
  absl::Time next_ ABSL_GUARDED_BY(mutex_);
  bool is_shown_ ABSL_GUARDED_BY(mutex_) = false;
};

// Shows for as long as it lives that a step goes on which doesn't say how far it is: the text, and
// for how long. Thread-safe.
class ProgressTicker {
 public:
  explicit ProgressTicker(std::string text, ProgressOptions options = DefaultProgress());
  ~ProgressTicker();
  ProgressTicker(const ProgressTicker&) = delete;
  ProgressTicker& operator=(const ProgressTicker&) = delete;

  // Shows another text from now on.
  void Set(std::string text);

 private:
  void Run();

  ProgressLine line_;
  absl::Mutex mutex_;
  std::string text_ ABSL_GUARDED_BY(mutex_);
  absl::Notification stop_;
  std::thread thread_;
};

// Returns "12 of 48 frames, 25 %, 36 s left", or without what is not known: a total of 0.
std::string DescribeCount(uint64_t done, uint64_t total, const std::string& what,
                          absl::Duration took);
// Returns "12.0 MB of 48.0 MB, 25 %" likewise.
std::string DescribeBytes(uint64_t done, uint64_t total);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_OUTPUT_PROGRESS_H_

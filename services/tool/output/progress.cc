#include "services/tool/output/progress.h"

#include <unistd.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/tool/output/result.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kOnTerminal = absl::Seconds(1);
constexpr absl::Duration kElsewhere = absl::Seconds(10);
constexpr size_t kWidth = 78;

double Megabytes(uint64_t bytes) { return 1e-6 * static_cast<double>(bytes); }

std::string Percent(uint64_t done, uint64_t total) {
  return absl::StrFormat("%.0f %%", 100 * static_cast<double>(done) / static_cast<double>(total));
}

}  // namespace

ProgressOptions DefaultProgress() {
  ProgressOptions options;
  options.is_terminal = isatty(STDERR_FILENO) != 0;
  options.is_quiet = WantsJson();
  return options;
}

ProgressLine::ProgressLine(ProgressOptions options)
    : options_(std::move(options)),
      next_(options_.clock() + (options_.is_terminal ? absl::ZeroDuration() : kElsewhere)) {}

ProgressLine::~ProgressLine() {
  absl::MutexLock lock(&mutex_);
  if (is_shown_ && options_.is_terminal) {
    std::fprintf(options_.out, "\r%s\r", std::string(kWidth, ' ').c_str());
    std::fflush(options_.out);
  }
}

void ProgressLine::Tell(const std::string& text) {
  if (options_.is_quiet) return;
  const absl::Time now = options_.clock();
  absl::MutexLock lock(&mutex_);
  if (now < next_) return;
  next_ = now + (options_.is_terminal ? kOnTerminal : kElsewhere);
  is_shown_ = true;
  if (options_.is_terminal) {
    std::string line = text.substr(0, kWidth);
    line.resize(kWidth, ' ');
    std::fprintf(options_.out, "\r%s", line.c_str());
  } else {
    std::fprintf(options_.out, "progress: %s\n", text.c_str());
  }
  std::fflush(options_.out);
}

ProgressTicker::ProgressTicker(std::string text, ProgressOptions options)
    : line_(std::move(options)),
      text_(std::move(text)),
      thread_(StartThread("progress", [this] { Run(); })) {}

ProgressTicker::~ProgressTicker() {
  stop_.Notify();
  thread_.join();
}

void ProgressTicker::Set(std::string text) {
  absl::MutexLock lock(&mutex_);
  text_ = std::move(text);
}

void ProgressTicker::Run() {
  absl::Duration took;
  while (!stop_.WaitForNotificationWithTimeout(absl::Seconds(1))) {
    took += absl::Seconds(1);
    std::string text;
    {
      absl::MutexLock lock(&mutex_);
      text = text_;
    }
    line_.Tell(absl::StrCat(text, ", ", absl::FormatDuration(took)));
  }
}

std::string DescribeCount(uint64_t done, uint64_t total, const std::string& what,
                          absl::Duration took) {
  if (total == 0) return absl::StrCat(done, " ", what);
  std::string text = absl::StrCat(done, " of ", total, " ", what, ", ", Percent(done, total));
  if (done > 0 && done < total) {
    const double left_s =
        absl::ToDoubleSeconds(took) * static_cast<double>(total - done) / static_cast<double>(done);
    absl::StrAppendFormat(&text, ", %.0f s left", left_s);
  }
  return text;
}

std::string DescribeBytes(uint64_t done, uint64_t total) {
  if (total == 0) return absl::StrFormat("%.1f MB", Megabytes(done));
  return absl::StrFormat("%.1f MB of %.1f MB, %s", Megabytes(done), Megabytes(total),
                         Percent(done, total));
}

}  // namespace corbslam::services

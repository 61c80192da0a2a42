#include "services/observe/tracing/trace_file.h"

#include <glog/logging.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace corbslam::services {

absl::StatusOr<std::unique_ptr<TraceFile>> TraceFile::Open(const std::string& path,
                                                           absl::string_view process,
                                                           const TraceFileOptions& options) {
  // The old file is kept, so that a restart does not lose what led to a crash.
  std::error_code error;
  // Where a link leads is what is kept: the link stays.
  const std::filesystem::path old = std::filesystem::canonical(path, error);
  if (!error && std::filesystem::is_regular_file(old, error)) {
    std::filesystem::rename(old, old.string() + ".before", error);
  }
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  const int number = ProcessNumber(process);
  file << "[\n" << ProcessNameLine(process, number) << ",\n" << std::flush;
  if (!file) return absl::UnavailableError(absl::StrCat("can't write the trace file ", path));
  return std::unique_ptr<TraceFile>(new TraceFile(path, std::move(file), number, options));
}

TraceFile::TraceFile(std::string path, std::ofstream file, int process,
                     const TraceFileOptions& options)
    : path_(std::move(path)),
      process_(process),
      options_(options),
      file_(std::move(file)),
      thread_([this] { Run(); }) {}

TraceFile::~TraceFile() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  thread_.join();
  if (const uint64_t lost = dropped(); lost > 0) {
    LOG(WARNING) << path_ << " lacks " << lost << " events";
  }
}

void TraceFile::Add(const KeyframeEvent& event) {
  std::string line = ToTraceLine(event, process_);
  absl::MutexLock lock(&mutex_);
  AddLine(std::move(line));
}

void TraceFile::Add(const std::vector<KeyframeEvent>& events) {
  for (const KeyframeEvent& event : events) Add(event);
}

void TraceFile::AddLine(std::string line) {
  if (waiting_.size() < options_.max_waiting) {
    waiting_.push_back(std::move(line));
    return;
  }
  LOG_IF(WARNING, dropped_ == 0) << path_
                                 << " lacks events: they come faster than they are written";
  ++dropped_;
}

uint64_t TraceFile::dropped() const {
  absl::MutexLock lock(&mutex_);
  return dropped_;
}

bool TraceFile::Write(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) file_ << line << ",\n";
  return static_cast<bool>(file_.flush());
}

void TraceFile::Run() {
  while (true) {
    std::vector<std::string> lines;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(this, &TraceFile::HasNews));
      if (waiting_.empty()) return;
      lines.swap(waiting_);
    }
    if (Write(lines)) continue;
    absl::MutexLock lock(&mutex_);
    LOG_IF(WARNING, dropped_ == 0) << path_ << " can't be written: it lacks events from here on";
    dropped_ += lines.size();
  }
}

}  // namespace corbslam::services

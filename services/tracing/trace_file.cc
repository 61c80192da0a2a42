#include "services/tracing/trace_file.h"

#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace corbslam {

absl::StatusOr<std::unique_ptr<TraceFile>> TraceFile::Open(const std::string& path,
                                                           absl::string_view process,
                                                           const TraceFileOptions& options) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  const int number = ProcessNumber(process);
  file << "[\n" << ProcessNameLine(process, number) << ",\n" << std::flush;
  if (!file) return absl::UnavailableError(absl::StrCat("can't write the trace file ", path));
  return std::unique_ptr<TraceFile>(new TraceFile(std::move(file), number, options));
}

TraceFile::TraceFile(std::ofstream file, int process, const TraceFileOptions& options)
    : process_(process), options_(options), file_(std::move(file)), thread_([this] { Run(); }) {}

TraceFile::~TraceFile() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  thread_.join();
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
  } else {
    ++dropped_;
  }
}

uint64_t TraceFile::dropped() const {
  absl::MutexLock lock(&mutex_);
  return dropped_;
}

void TraceFile::Run() {
  while (true) {
    std::vector<std::string> lines;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(this, &TraceFile::HasNews));
      if (waiting_.empty()) return;
      lines.swap(waiting_);
    }
    for (const std::string& line : lines) file_ << line << ",\n";
    file_.flush();
  }
}

}  // namespace corbslam

// Writes a file of trace events beside the work that they are about.
#ifndef CORBSLAM_SERVICES_OBSERVE_TRACING_TRACE_FILE_H_
#define CORBSLAM_SERVICES_OBSERVE_TRACING_TRACE_FILE_H_

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "services/observe/tracing/keyframe_events.h"

namespace corbslam::services {

struct TraceFileOptions {
  // Most events that may wait for the disk; further ones are dropped.
  size_t max_waiting = 1 << 16;
};

// A file that is a JSON array without the closing bracket, as Chrome's format allows: "[" and then
// a line for each event. So it can be read at any time, also after a crash. Thread-safe. Events
// that are dropped or can't be written are counted, and the log says so: at the first, and at the
// end.
class TraceFile {
 public:
  // Begins the file anew; one that is there becomes PATH.before. `process` is how viewers call this
  // process. UNAVAILABLE if it can't be written.
  static absl::StatusOr<std::unique_ptr<TraceFile>> Open(const std::string& path,
                                                         absl::string_view process,
                                                         const TraceFileOptions& options = {});
  // The destructor writes what waits.
  ~TraceFile();
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  // Takes events without ever waiting for the disk.
  void Add(const KeyframeEvent& event);
  void Add(const std::vector<KeyframeEvent>& events);

  // Returns the number of events that are not in the file.
  uint64_t dropped() const;

 private:
  TraceFile(std::string path, std::ofstream file, int process, const TraceFileOptions& options);

  void Run();
  void AddLine(std::string line) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns false if not all lines were written.
  bool Write(const std::vector<std::string>& lines);
  bool HasNews() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return stop_ || !waiting_.empty(); }

  const std::string path_;
  const int process_;
  const TraceFileOptions options_;
  std::ofstream file_;  // Only the thread uses it.
  mutable absl::Mutex mutex_;
  std::vector<std::string> waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t dropped_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_TRACING_TRACE_FILE_H_

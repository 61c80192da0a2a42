// Writes the log as JSON, an object a line.
#ifndef CORBSLAM_SERVICES_OBSERVE_LOGGING_JSON_LOG_SINK_H_
#define CORBSLAM_SERVICES_OBSERVE_LOGGING_JSON_LOG_SINK_H_

#include <glog/logging.h>

#include <cstdio>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Returns one line of the log without its newline: {"time", "severity", "file", "line", "message"}
// and, where the message begins with them (log_fields.h), "mission" and "agent", which the message
// is then without. Bytes that are no UTF-8 are replaced.
std::string LogLineToJson(google::LogSeverity severity, absl::string_view file, int line,
                          absl::Time time, absl::string_view message);

// Writes all lines to a file. Thread-safe.
class JsonLogSink : public google::LogSink {
 public:
  // `out` is not owned.
  explicit JsonLogSink(std::FILE* out) : out_(out) {}

  void send(google::LogSeverity severity, const char* full_filename, const char* base_filename,
            int line, const google::LogMessageTime& time, const char* message,
            size_t message_len) override;

 private:
  absl::Mutex mutex_;
  std::FILE* const out_ ABSL_PT_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_LOGGING_JSON_LOG_SINK_H_

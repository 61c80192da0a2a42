// What the programs' logs look like.
#ifndef CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FORMAT_H_
#define CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FORMAT_H_

namespace corbslam {

enum class LogFormat {
  kText,  // glog's lines.
  kJson,  // An object a line (json_log_sink.h).
};

// Begins logging to standard error. Once a process.
void StartLogging(const char* program, LogFormat format);
// Ends it: nothing may be logged afterwards.
void EndLogging();

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FORMAT_H_

#include "services/observe/logging/log_format.h"

#include <glog/logging.h>

#include "services/observe/logging/grpc_log.h"
#include "services/observe/logging/json_log_sink.h"

namespace corbslam::services {
namespace {

// The sink is never destroyed: other threads may still log at the end.
JsonLogSink& StandardError() {
  static JsonLogSink& sink = *new JsonLogSink(stderr);
  return sink;
}

}  // namespace

void StartLogging(const char* program, LogFormat format) {
  if (format == LogFormat::kJson) {
    // The sink alone writes: glog neither to standard error (but for the stack of a fatal line)
    // nor to files.
    FLAGS_stderrthreshold = google::NUM_SEVERITIES;
    for (int severity = 0; severity < google::NUM_SEVERITIES; ++severity) {
      google::SetLogDestination(severity, "");
    }
    google::AddLogSink(&StandardError());
  } else {
    FLAGS_logtostderr = true;
  }
  google::InitGoogleLogging(program);
  SendGrpcLinesToLog();
}

void EndLogging() { google::ShutdownGoogleLogging(); }

}  // namespace corbslam::services

// Chooses what the programs' logs look like.
#ifndef CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FORMAT_H_
#define CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FORMAT_H_

namespace corbslam::services {

enum class LogFormat {
  kText,  // Lines as glog writes them.
  kJson,  // An object a line (json_log_sink.h).
};

// Begins logging to standard error, gRPC's own lines included (grpc_log.h). A process calls it
// once.
void StartLogging(const char* program, LogFormat format);
// Ends logging: nothing may be logged afterwards.
void EndLogging();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_LOGGING_LOG_FORMAT_H_

#include "services/observe/logging/grpc_log.h"

#include <glog/logging.h>
#include <grpc/support/log.h>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace corbslam::services {
namespace {

// gRPC's threads may still log at the end.
GrpcLines& Lines() {
  static GrpcLines& lines = *new GrpcLines();
  return lines;
}

void Log(gpr_log_func_args* args) {
  const bool is_error = args->severity == GPR_LOG_SEVERITY_ERROR;
  // What somebody asked for by GRPC_VERBOSITY is wanted in full.
  const std::optional<std::string> line =
      is_error ? Lines().Add(args->file, args->line, args->message, absl::Now())
               : std::string(args->message);
  if (!line.has_value()) return;
  google::LogMessage(args->file, args->line, is_error ? google::GLOG_WARNING : google::GLOG_INFO)
          .stream()
      << "gRPC: " << *line;
}

}  // namespace

std::optional<std::string> GrpcLines::Add(absl::string_view file, int line,
                                          absl::string_view message, absl::Time now) {
  absl::MutexLock lock(&mutex_);
  Place& place = places_[{std::string(file), line}];
  if (!place.reminder.IsDue(now)) {
    ++place.left_out;
    return std::nullopt;
  }
  const uint64_t left_out = std::exchange(place.left_out, 0);
  if (left_out == 0) return std::string(message);
  return absl::StrCat(message, " (and ", left_out, left_out == 1 ? " line" : " lines",
                      " like it since the last one)");
}

void SendGrpcLinesToLog() { gpr_set_log_function(&Log); }

}  // namespace corbslam::services

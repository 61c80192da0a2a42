// Sends what gRPC itself has to say to our log, instead of lines of another form beside it.
#ifndef CORBSLAM_SERVICES_OBSERVE_LOGGING_GRPC_LOG_H_
#define CORBSLAM_SERVICES_OBSERVE_LOGGING_GRPC_LOG_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "slam/util/rare_reminder.h"

namespace corbslam::services {

// Decides which of gRPC's lines are worth one of ours: a place in its code says the same again and
// again while a server is away. Thread-safe.
class GrpcLines {
 public:
  // Returns the line to write; nullopt if the place has said something lately. The lines that were
  // left out are counted in the next one.
  std::optional<std::string> Add(absl::string_view file, int line, absl::string_view message,
                                 absl::Time now);

 private:
  struct Place {
    RareReminder reminder;
    uint64_t left_out = 0;
  };

  absl::Mutex mutex_;
  // By file and line; there are as many as gRPC's code has.
  std::map<std::pair<std::string, int>, Place> places_ ABSL_GUARDED_BY(mutex_);
};

// From now on gRPC's errors are our warnings, as "gRPC: ...": a call's own failure is told by who
// made the call. What GRPC_VERBOSITY asks for beyond errors comes as information.
void SendGrpcLinesToLog();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_LOGGING_GRPC_LOG_H_

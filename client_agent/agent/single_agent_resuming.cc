// How SingleAgent goes on with the local map of an earlier process.
#include <glog/logging.h>

#include "absl/strings/str_cat.h"
#include "client_agent/agent/single_agent.h"

namespace corbslam::client_agent {

void SingleAgent::CheckTimeGoesOn(int64_t timestamp_ns) {
  if (resuming_->began_ns.has_value()) return;
  resuming_->began_ns = timestamp_ns;
  const std::optional<int64_t> ended_ns = resuming_->ended_ns;
  if (!ended_ns.has_value() || timestamp_ns > *ended_ns) return;
  NoteNotResumed(absl::StrCat("the first frame is of ", timestamp_ns, " ns, and its last one of ",
                              *ended_ns,
                              " ns: time goes back (a recording that is played again, or a clock "
                              "that began anew), and the trajectory of one local map can't"));
  BeginLocalMap();
}

void SingleAgent::NoteResumed(const TrackingResult& result) {
  if (result.state != TrackingState::kTracking) return;
  const double after_s =
      static_cast<double>(result.timestamp_ns - resuming_->began_ns.value_or(0)) * 1e-9;
  resuming_.reset();
  LOG(INFO) << "local map " << ToString(result.local_map) << " goes on, " << after_s
            << " s after the first frame";
  absl::MutexLock lock(&mutex_);
  status_.resumed = true;
  status_.resumed_after_s = after_s;
}

void SingleAgent::NoteNotResumed(const std::string& why) {
  resuming_.reset();
  LOG(WARNING) << "the local map of an earlier process does not go on, and a new one begins: "
               << why;
  absl::MutexLock lock(&mutex_);
  status_.why_not_resumed = why;
}

}  // namespace corbslam::client_agent

// Threads that last as long as the program, for a library that must never see one of its callers
// end.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_LASTING_THREAD_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_LASTING_THREAD_H_

#include <functional>
#include <memory>

#include "absl/synchronization/notification.h"

namespace corbslam::client_agent {

// Runs `job` on a thread that goes on to wait for another job when it is done; the program has as
// many of them as ran at once. OpenNI remembers each thread that has waited for a picture and asks,
// when a new one comes, whether the old ones live (pthread_kill): of a thread that has ended and
// whose stack was given back, this reads memory that is no longer there. Returns what is notified
// once the job is done.
std::shared_ptr<const absl::Notification> RunOnLastingThread(std::function<void()> job);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_LASTING_THREAD_H_

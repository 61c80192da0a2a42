// Has requests of many missions worked on in turns.
#ifndef CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_WORK_QUEUE_H_
#define CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_WORK_QUEUE_H_

#include <grpcpp/support/server_callback.h>

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "services/convert/work/work.h"
#include "services/server/task_pool.h"
#include "services/server/work_turns.h"

namespace corbslam::services {

// Whose a request is, and whether it may wait for others (WorkTurns).
struct WorkOwner {
  std::string mission;
  bool may_wait = false;
};

// Returns what the call says; of callers that don't say their mission, the caller's host.
inline WorkOwner OwnerOf(const grpc::CallbackServerContext& context, bool may_wait) {
  const auto& headers = context.client_metadata();
  const auto it = headers.find(kMissionHeader);
  if (it != headers.end() && it->second.size() > 0) {
    return {{it->second.data(), it->second.size()}, may_wait};
  }
  std::string peer = context.peer();
  return {peer.substr(0, peer.rfind(':')), may_wait};
}

// It outlives the pool that it uses. Thread-safe.
class WorkQueue {
 public:
  void Schedule(TaskPool& pool, WorkOwner owner, std::function<void()> task)
      ABSL_LOCKS_EXCLUDED(mutex_) {
    {
      absl::MutexLock lock(&mutex_);
      const uint64_t id = ++last_id_;
      tasks_[id] = std::move(task);
      turns_.Add({id, std::move(owner.mission), owner.may_wait}, absl::Now());
    }
    // A thread of the pool takes whichever is next when it has time.
    pool.Schedule([this] { WorkOnNext(); });
  }

 private:
  void WorkOnNext() ABSL_LOCKS_EXCLUDED(mutex_) {
    std::string mission;
    std::function<void()> task;
    {
      absl::MutexLock lock(&mutex_);
      const WorkTurns::Request request = turns_.Begin(absl::Now());
      mission = request.mission;
      task = std::move(tasks_.at(request.id));
      tasks_.erase(request.id);
    }
    task();
    absl::MutexLock lock(&mutex_);
    turns_.End(mission);
  }

  absl::Mutex mutex_;
  WorkTurns turns_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  uint64_t last_id_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_WORK_QUEUE_H_

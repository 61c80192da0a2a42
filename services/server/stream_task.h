// Provides the state machine of a streaming call: callbacks note what happened, and one thread at a
// time works.
#ifndef CORBSLAM_SERVICES_SERVER_STREAM_TASK_H_
#define CORBSLAM_SERVICES_SERVER_STREAM_TASK_H_

#include <functional>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/server/task_pool.h"

namespace corbslam::services {

// Lets others call a stream that may be gone. Thread-safe.
class StreamLink {
 public:
  // Returns a function that calls `action`, with what it is given itself, until the link is cut,
  // and does nothing afterwards. It may outlive the link.
  template <typename Action>
  auto Guard(Action action) const {
    return [state = state_, action = std::move(action)](const auto&... given) {
      absl::MutexLock lock(&state->mutex);
      if (state->joined) action(given...);
    };
  }

  // Cuts the link and waits for an action that is under way, so that no action may call it.
  void Cut() {
    absl::MutexLock lock(&state_->mutex);
    state_->joined = false;
  }

 private:
  struct State {
    absl::Mutex mutex;
    bool joined ABSL_GUARDED_BY(mutex) = true;
  };
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

// Serves as the base of reactors whose callbacks only Note what happened. All work is done by
// DoJob, on the pool and by one thread at a time, until NextJob names nothing more. `Job` is an
// enumeration with kNone and kFinish among its values. A stream that waits for its caller holds no
// thread.
template <typename Job>
class StreamTask {
 public:
  // Says which threads of the pool work: those of robots' tasks or those of look-ups.
  enum class Threads { kTasks, kLookUps };

  StreamTask(TaskPool& pool, Threads threads) : pool_(pool), threads_(threads) {}
  virtual ~StreamTask() = default;
  StreamTask(const StreamTask&) = delete;
  StreamTask& operator=(const StreamTask&) = delete;

 protected:
  // Returns what is to be done, given all that was noted.
  virtual Job NextJob() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) = 0;
  // Changes the state before `job` is done, so that what is noted meanwhile is seen by NextJob.
  virtual void BeginJob(Job job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { (void)job; }
  // Does the job, without the lock. kFinish comes once and last: this object may be gone when DoJob
  // returns.
  virtual void DoJob(Job job) = 0;

  // Makes a change of the state, under the lock, and sees to it that somebody works if there is
  // anything to do.
  template <typename Change>
  void Note(const Change& change) {
    {
      absl::MutexLock lock(&mutex_);
      change();
      if (working_ || finished_ || NextJob() == Job::kNone) return;
      working_ = true;
    }
    if (threads_ == Threads::kTasks) {
      pool_.Schedule([this] { Work(); });
    } else {
      pool_.ScheduleLookUp([this] { Work(); });
    }
  }

  TaskPool& pool() const { return pool_; }

  // Ends all work of a stream that is refused: whatever is noted, nothing is done.
  void NeverWork() {
    absl::MutexLock lock(&mutex_);
    finished_ = true;
  }

  mutable absl::Mutex mutex_;
  // The derived class cuts it in OnDone, before the stream is deleted.
  StreamLink link_;

 private:
  void Work() {
    while (true) {
      Job job;
      {
        absl::MutexLock lock(&mutex_);
        job = NextJob();
        working_ = job != Job::kNone;
        finished_ = job == Job::kFinish;
        BeginJob(job);
      }
      if (job == Job::kNone) return;
      DoJob(job);
      // After the last job this object may be gone.
      if (job == Job::kFinish) return;
    }
  }

  TaskPool& pool_;
  const Threads threads_;
  bool working_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_STREAM_TASK_H_

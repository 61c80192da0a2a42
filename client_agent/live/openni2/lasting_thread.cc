#include "client_agent/live/openni2/lasting_thread.h"

#include <deque>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::client_agent {
namespace {

struct Job {
  std::function<void()> run;
  std::shared_ptr<absl::Notification> done;
};

class LastingThreads {
 public:
  void Run(Job job) {
    absl::MutexLock lock(&mutex_);
    waiting_.push_back(std::move(job));
    if (idle_ >= waiting_.size()) return;
    std::thread([this] { Work(); }).detach();
  }

 private:
  [[noreturn]] void Work() {
    while (true) {
      Job job = Next();
      job.run();
      job.run = nullptr;  // What it holds goes before anybody hears of its end.
      job.done->Notify();
    }
  }
  Job Next() {
    absl::MutexLock lock(&mutex_);
    ++idle_;
    mutex_.Await(absl::Condition(
        +[](std::deque<Job>* waiting) { return !waiting->empty(); }, &waiting_));
    --idle_;
    Job job = std::move(waiting_.front());
    waiting_.pop_front();
    return job;
  }

  absl::Mutex mutex_;
  std::deque<Job> waiting_ ABSL_GUARDED_BY(mutex_);
  size_t idle_ ABSL_GUARDED_BY(mutex_) = 0;  // Threads that wait for a job.
};

}  // namespace

std::shared_ptr<const absl::Notification> RunOnLastingThread(std::function<void()> job) {
  static auto* const threads = new LastingThreads;  // Its threads never end.
  auto done = std::make_shared<absl::Notification>();
  threads->Run({std::move(job), done});
  return done;
}

}  // namespace corbslam::client_agent

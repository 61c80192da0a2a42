// Simulates a writing thread that works when it is told to, for tests of the link.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_TESTING_FAKE_MAP_JOBS_H_
#define CORBSLAM_CLIENT_AGENT_LINK_TESTING_FAKE_MAP_JOBS_H_

#include <functional>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/link/map_jobs.h"

namespace corbslam::client_agent {

class FakeMapJobs : public MapJobs {
 public:
  using Job = std::function<void(GuardedMap&)>;

  void PostJob(Job job) override {
    absl::MutexLock lock(&mutex_);
    jobs_.push_back(std::move(job));
  }
  void OnPlaced(const PlacementChange&, const Map&) override { ++placed; }

  // Runs the jobs that were posted.
  void Run(GuardedMap& map) {
    std::vector<Job> jobs;
    {
      absl::MutexLock lock(&mutex_);
      jobs.swap(jobs_);
    }
    for (const Job& job : jobs) job(map);
  }
  size_t size() const {
    absl::MutexLock lock(&mutex_);
    return jobs_.size();
  }

  int placed = 0;

 private:
  mutable absl::Mutex mutex_;
  std::vector<Job> jobs_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_TESTING_FAKE_MAP_JOBS_H_

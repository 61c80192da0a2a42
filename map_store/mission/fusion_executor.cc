#include "map_store/mission/fusion_executor.h"

#include <glog/logging.h>

#include <utility>

#include "absl/time/clock.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kKeeperStepsLower = 10;
constexpr absl::Duration kAfterFailedSnapshot = absl::Minutes(1);

}  // namespace

void FusionExecutor::Start(ListMissions missions, int threads_per_lane) {
  missions_ = std::move(missions);
  threads_.emplace_back([this] { RunKeeper(); });
  if (worker_ == nullptr) return;
  for (int i = 0; i < threads_per_lane; ++i) {
    threads_.emplace_back([this] { RunLane(FusionLane::kGraph); });
    threads_.emplace_back([this] { RunLane(FusionLane::kAdjustment); });
  }
}

void FusionExecutor::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
    changed_.SignalAll();
  }
  if (threads_.empty()) return;
  for (const std::shared_ptr<Mission>& mission : missions_()) mission->CancelJobs();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void FusionExecutor::Wake() {
  absl::MutexLock lock(&mutex_);
  ++wakes_;
  changed_.SignalAll();
}

bool FusionExecutor::IsStopped() const {
  absl::MutexLock lock(&mutex_);
  return stop_;
}

bool FusionExecutor::RunOne(Mission& mission, FusionLane lane, bool& unavailable) {
  const std::optional<FusionJob> job = mission.StartJob(lane);
  if (!job.has_value()) return false;
  const ProgressCallback progress = [this, &job](double) {
    return !job->cancelled->load() && !IsStopped();
  };
  absl::StatusOr<FusionResult> result = RunRequest(job->work, *worker_, progress);
  watch_.Note(result.status());
  if (mission.FinishJob(lane, *job, std::move(result))) return true;
  unavailable = true;
  return false;
}

void FusionExecutor::RunLane(FusionLane lane) {
  uint64_t seen = 0;
  bool unavailable = false;
  while (WaitForWork(seen, unavailable)) {
    unavailable = false;
    bool did_something = false;
    // A round: each mission's turn comes after one request of each other.
    for (const std::shared_ptr<Mission>& mission : missions_()) {
      did_something = RunOne(*mission, lane, unavailable) || did_something;
    }
    // The other lane may have something to do now, and this one again.
    if (did_something) Wake();
  }
}

void FusionExecutor::RunKeeper() {
  // Robots wait for the other threads, nobody for this one.
  const absl::Status lowered = LowerThreadPriority(kKeeperStepsLower);
  LOG_IF(WARNING, !lowered.ok()) << "snapshots may hold up robots: " << lowered;
  uint64_t seen = 0;
  absl::Time next_try = absl::InfinitePast();
  while (WaitForWork(seen, false)) {
    if (absl::Now() < next_try) continue;
    for (const std::shared_ptr<Mission>& mission : missions_()) {
      const absl::Status kept = mission->KeepSnapshot([this] { return !IsStopped(); });
      if (kept.ok() || absl::IsCancelled(kept)) continue;
      // It is wanted again with the next batch, and would cost as much again.
      LOG(WARNING) << "no snapshot was written: " << kept;
      next_try = absl::Now() + kAfterFailedSnapshot;
    }
  }
}

bool FusionExecutor::WaitForWork(uint64_t& seen, bool unavailable) {
  absl::MutexLock lock(&mutex_);
  const absl::Time retry = unavailable ? absl::Now() + retry_after_ : absl::InfiniteFuture();
  // While the worker is away, new work is no reason to hurry.
  while (!stop_ && (unavailable || wakes_ == seen)) {
    if (changed_.WaitWithDeadline(&mutex_, retry)) break;
  }
  seen = wakes_;
  return !stop_;
}

void FusionExecutor::RunUntilIdle(Mission& mission) {
  mission.KeepSnapshot([] { return true; }).IgnoreError();
  if (worker_ == nullptr) return;
  bool unavailable = false;
  while (RunOne(mission, FusionLane::kGraph, unavailable) ||
         RunOne(mission, FusionLane::kAdjustment, unavailable)) {
  }
}

}  // namespace corbslam::map_store

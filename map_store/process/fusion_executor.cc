#include "map_store/process/fusion_executor.h"

#include "slam/util/named_thread.h"

namespace corbslam::map_store {

void FusionExecutor::Start(ListMissions missions, int threads_per_lane) {
  missions_ = std::move(missions);
  if (worker_ == nullptr) return;
  for (int i = 0; i < threads_per_lane; ++i) {
    for (const FusionLane lane : kFusionLanes) {
      threads_.push_back(StartThread("fusion", [this, lane] { RunLane(lane); }));
    }
  }
}

void FusionExecutor::Stop() {
  signal_.Stop();
  if (threads_.empty()) return;
  for (const std::weak_ptr<Mission>& listed : missions_()) {
    if (const auto mission = listed.lock()) mission->fusion().CancelJobs();
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

FusionExecutor::Turn FusionExecutor::TurnOf(JobEnd end) {
  switch (end) {
    case JobEnd::kTryLater:
      return Turn::kTryLater;
    case JobEnd::kRefused:
      return Turn::kRefused;
    case JobEnd::kDone:
      break;
  }
  return Turn::kDone;
}

FusionExecutor::Turn FusionExecutor::RunOne(Mission& mission, FusionLane lane) {
  if (const auto retried = mission.fusion().RetryCommit(lane)) return TurnOf(*retried);
  std::optional<FusionJob> job = mission.fusion().StartJob(lane);
  if (!job.has_value()) return Turn::kNothingToDo;
  const ProgressCallback progress = [this, &job](double) {
    return !job->cancelled->load() && !signal_.stopped();
  };
  absl::StatusOr<FusionResult> result = RunRequest(job->work, *worker_, progress);
  watch_.Note(result.status());
  return TurnOf(mission.fusion().FinishJob(lane, *std::move(job), std::move(result)));
}

void FusionExecutor::RunLane(FusionLane lane) {
  absl::Duration most = absl::InfiniteDuration();
  for (uint64_t seen = 0; signal_.Wait(seen, most);) {
    bool try_later = false;
    bool refused = false;
    bool did_something = false;
    // In each round a mission's turn comes after one request of each other mission.
    for (const std::weak_ptr<Mission>& listed : missions_()) {
      const std::shared_ptr<Mission> mission = listed.lock();
      if (mission == nullptr) continue;
      Turn turn = RunOne(*mission, lane);
      const bool may_tidy = turn == Turn::kNothingToDo || turn == Turn::kDone;
      if (may_tidy && lane == FusionLane::kGraph &&
          (mission->retiring().RunOne() || mission->joining().RunOne())) {
        turn = Turn::kDone;
      }
      did_something = did_something || turn == Turn::kDone;
      try_later = try_later || turn == Turn::kTryLater;
      refused = refused || turn == Turn::kRefused;
    }
    // The journal of one mission that takes nothing keeps no other mission waiting.
    most = refused ? retry_after_ : absl::InfiniteDuration();
    // The other lane may have something to do now, and this one again.
    if (did_something) {
      when_done_();
      signal_.Wake();
    }
    if (!try_later) continue;
    // While the worker is away, new work does not shorten the pause.
    if (!signal_.WaitFor(retry_after_)) return;
    signal_.Wake();
  }
}

void FusionExecutor::RunUntilIdle(Mission& mission) {
  if (worker_ == nullptr) return;
  while (RunOne(mission, FusionLane::kGraph) == Turn::kDone ||
         RunOne(mission, FusionLane::kAdjustment) == Turn::kDone || mission.retiring().RunOne() ||
         mission.joining().RunOne()) {
  }
  when_done_();
}

}  // namespace corbslam::map_store

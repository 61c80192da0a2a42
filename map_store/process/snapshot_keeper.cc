#include "map_store/process/snapshot_keeper.h"

#include <glog/logging.h>

#include <utility>

#include "slam/util/named_thread.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kStepsLower = 10;
constexpr absl::Duration kAfterFailure = absl::Minutes(1);

}  // namespace

void SnapshotKeeper::Start(ListMissions missions, std::function<void()> when_written) {
  missions_ = std::move(missions);
  when_written_ = std::move(when_written);
  thread_ = StartThread("snapshots", [this] { Run(); });
}

void SnapshotKeeper::Stop() {
  signal_.Stop();
  if (thread_.joinable()) thread_.join();
}

void SnapshotKeeper::Run() {
  // Robots wait for the other threads, but nobody waits for this one.
  StepBehindRobots(kStepsLower, "snapshots");
  absl::Time next_try = absl::InfinitePast();
  for (uint64_t seen = 0; signal_.Wait(seen);) {
    if (clock_() < next_try) continue;
    for (const std::weak_ptr<Mission>& listed : missions_()) {
      const std::shared_ptr<Mission> mission = listed.lock();
      if (mission == nullptr) continue;
      const absl::StatusOr<bool> kept =
          mission->snapshots().Keep([this] { return !signal_.stopped(); });
      if (kept.ok() && *kept) when_written_();
      if (kept.ok() || absl::IsCancelled(kept.status())) continue;
      // The next batch would want the snapshot again, which would cost as much again.
      LOG(WARNING) << "no snapshot was written: " << kept.status();
      next_try = clock_() + kAfterFailure;
    }
  }
}

}  // namespace corbslam::map_store

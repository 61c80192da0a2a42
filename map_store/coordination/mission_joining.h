// Makes one local map of an agent's old sessions while nothing is fused of the mission, and deletes
// sessions for administrators.
#ifndef CORBSLAM_MAP_STORE_COORDINATION_MISSION_JOINING_H_
#define CORBSLAM_MAP_STORE_COORDINATION_MISSION_JOINING_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/coordination/fusion_coordinator.h"
#include "map_store/coordination/mission_retiring.h"
#include "map_store/joining/forgetting.h"
#include "map_store/joining/joining_choice.h"
#include "map_store/mission/mission_strand.h"

namespace corbslam::map_store {

// Thread-safe.
class MissionJoining {
 public:
  // None of them is owned; all must outlive it. `notify` is called, without locks, when local maps
  // became one, or were deleted.
  MissionJoining(MissionStrand& strand, const FusionCoordinator& fusion,
                 const MissionRetiring& retiring, std::function<void()> notify)
      : strand_(strand), fusion_(fusion), retiring_(retiring), notify_(std::move(notify)) {}

  // Makes one local map of two, if fusion rests but for queries and nothing is left to be looked
  // at for retiring. Returns whether there were two, and that is done. A journal that takes nothing
  // leaves it for later.
  bool RunOne();
  // Returns whether local maps are still to become one.
  bool IsDue() const;

  // Deletes the local maps that the request names, and returns them; with `dry_run` it deletes
  // nothing. The deletion is durable then. FAILED_PRECONDITION while fusion is busy with them, and
  // what ChooseForgotten returns.
  absl::StatusOr<ForgottenLocalMaps> Forget(const ForgetRequest& request);

 private:
  bool IsWanted() const {
    return strand_.options().join_local_maps && strand_.environment().has_worker;
  }

  // Returns what is to be joined next.
  std::optional<LocalMapJoining> Choose(const MissionState& state) const;

  MissionStrand& strand_;
  const FusionCoordinator& fusion_;
  const MissionRetiring& retiring_;
  const std::function<void()> notify_;
  // The version of the state in which nothing was to be done, plus one: looking takes a while.
  mutable std::atomic<uint64_t> rests_at_ = 0;
  mutable absl::Mutex memory_mutex_;
  mutable JoiningMemory memory_ ABSL_GUARDED_BY(memory_mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_COORDINATION_MISSION_JOINING_H_

// What is being fused of a mission, and how its adjustments have gone.
#ifndef CORBSLAM_MAP_STORE_MISSION_FUSION_LANES_H_
#define CORBSLAM_MAP_STORE_MISSION_FUSION_LANES_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>

#include "map_store/fusion/fusion_policy.h"

namespace corbslam::map_store {

// Verification and fusing, one after the other; bundle adjustment beside them.
enum class FusionLane { kGraph, kAdjustment };
inline constexpr std::array<FusionLane, 2> kFusionLanes = {FusionLane::kGraph,
                                                           FusionLane::kAdjustment};

FusionLane LaneOf(const FusionAction& action);

// Set when the result would be worth nothing any more.
using CancelFlag = std::shared_ptr<std::atomic<bool>>;

// Not thread-safe.
class FusionLanes {
 public:
  bool IsBusy(FusionLane lane) const { return LaneAt(lane).cancelled != nullptr; }
  // None: the lane is idle.
  std::optional<FusionAction::Kind> Running(FusionLane lane) const;
  // The lane must be idle, and is the caller's until it is released.
  CancelFlag Claim(const FusionAction& action);
  void Release(FusionLane lane) { LaneAt(lane).cancelled.reset(); }
  void CancelAll();

  // An adjustment of the island runs, and is not cancelled.
  bool IsAdjusting(IslandId island) const;
  // Cancels the adjustment that runs if the action has changed what it adjusts, and counts that.
  void CancelAdjustment(const FusionAction& overtaken_by);

  // Of the island's adjustments since the last one that was committed.
  size_t CountCancelled(IslandId island) const;
  // One more has failed; returns how many that were.
  int NoteFailedAdjustment(IslandId island) { return ++trouble_[island].failed; }
  void ForgetTrouble(IslandId island) { trouble_.erase(island); }
  void ForgetTrouble() { trouble_.clear(); }

 private:
  struct Lane {
    FusionAction::Kind kind = FusionAction::Kind::kQuery;
    IslandId target;
    CancelFlag cancelled;  // Null: the lane is idle.
  };
  struct Trouble {
    int failed = 0;
    size_t cancelled = 0;
  };

  Lane& LaneAt(FusionLane lane) { return lanes_[static_cast<size_t>(lane)]; }
  const Lane& LaneAt(FusionLane lane) const { return lanes_[static_cast<size_t>(lane)]; }

  std::array<Lane, kFusionLanes.size()> lanes_;
  std::map<IslandId, Trouble> trouble_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_FUSION_LANES_H_

// Knows what is being fused of a mission, and how its adjustments have gone.
#ifndef CORBSLAM_MAP_STORE_COORDINATION_FUSION_LANES_H_
#define CORBSLAM_MAP_STORE_COORDINATION_FUSION_LANES_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>

#include "map_store/fusion/fusion_policy.h"

namespace corbslam::map_store {

// The graph lane does verification and fusing, one after the other; bundle adjustment runs beside
// it.
enum class FusionLane { kGraph, kAdjustment };
inline constexpr std::array<FusionLane, 2> kFusionLanes = {FusionLane::kGraph,
                                                           FusionLane::kAdjustment};

FusionLane LaneOf(const FusionAction& action);

// True once the result would be worth nothing any more.
using CancelFlag = std::shared_ptr<std::atomic<bool>>;

// Keeps who has which lane, and counts adjustments that went wrong. Not thread-safe.
class FusionLanes {
 public:
  bool IsBusy(FusionLane lane) const { return LaneAt(lane).cancelled != nullptr; }
  // Returns what runs; nullopt if the lane is idle.
  std::optional<FusionAction::Kind> Running(FusionLane lane) const;
  // Gives the lane, which must be idle, to the caller until it is released.
  CancelFlag Claim(const FusionAction& action);
  void Release(FusionLane lane) { LaneAt(lane).cancelled.reset(); }
  void CancelAll();

  // Returns whether an adjustment of the island runs and is not cancelled.
  bool IsAdjusting(IslandId island) const;
  // Cancels the adjustment that runs if the action has changed what it adjusts, and counts that.
  void CancelAdjustment(const FusionAction& overtaken_by);

  // Returns how many of the island's adjustments were cancelled since the last one that was
  // committed.
  size_t CountCancelled(IslandId island) const;
  // Counts one more failed adjustment; returns how many that were.
  int NoteFailedAdjustment(IslandId island) { return ++trouble_[island].failed; }
  void ForgetTrouble(IslandId island) { trouble_.erase(island); }
  void ForgetTrouble() { trouble_.clear(); }

 private:
  struct Lane {
    FusionAction::Kind kind = FusionAction::Kind::kQuery;
    IslandId target;
    // Null: the lane is idle.
    CancelFlag cancelled;
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

#endif  // CORBSLAM_MAP_STORE_COORDINATION_FUSION_LANES_H_

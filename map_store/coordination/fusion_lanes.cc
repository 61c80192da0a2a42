#include "map_store/coordination/fusion_lanes.h"

namespace corbslam::map_store {

FusionLane LaneOf(const FusionAction& action) {
  return action.kind == FusionAction::Kind::kAdjust ? FusionLane::kAdjustment : FusionLane::kGraph;
}

std::optional<FusionAction::Kind> FusionLanes::Running(FusionLane lane) const {
  if (!IsBusy(lane)) return std::nullopt;
  return LaneAt(lane).kind;
}

CancelFlag FusionLanes::Claim(const FusionAction& action) {
  Lane& lane = LaneAt(LaneOf(action));
  lane = {action.kind, action.target, std::make_shared<std::atomic<bool>>(false)};
  return lane.cancelled;
}

void FusionLanes::CancelAll() {
  for (const Lane& lane : lanes_) {
    if (lane.cancelled != nullptr) lane.cancelled->store(true);
  }
}

bool FusionLanes::IsAdjusting(IslandId island) const {
  const Lane& lane = LaneAt(FusionLane::kAdjustment);
  return lane.cancelled != nullptr && lane.target == island && !lane.cancelled->load();
}

void FusionLanes::CancelAdjustment(const FusionAction& overtaken_by) {
  const Lane& lane = LaneAt(FusionLane::kAdjustment);
  const bool stale = lane.target == overtaken_by.target || lane.target == overtaken_by.source;
  if (!stale || lane.cancelled == nullptr || lane.cancelled->exchange(true)) return;
  ++trouble_[overtaken_by.target].cancelled;
}

size_t FusionLanes::CountCancelled(IslandId island) const {
  const auto it = trouble_.find(island);
  return it == trouble_.end() ? 0 : it->second.cancelled;
}

}  // namespace corbslam::map_store

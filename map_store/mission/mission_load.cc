#include "map_store/mission/mission_load.h"

#include <algorithm>
#include <utility>

namespace corbslam::map_store {
namespace {

using Kind = FusionAction::Kind;

size_t& CountOf(Kind kind, FusionRequestCounts& counts) {
  if (kind == Kind::kQuery) return counts.verify;
  return kind == Kind::kAdjust ? counts.adjust : counts.fuse;
}

// Changes the summary as if the action were done, without what would follow from it.
void TakeAsDone(const FusionAction& action, FusionSummary& summary) {
  std::erase_if(summary.waiting, [&action](const FusionSummary::OverlapSummary& overlap) {
    return std::find(action.overlaps.begin(), action.overlaps.end(), overlap.id) !=
           action.overlaps.end();
  });
  for (FusionSummary::IslandSummary& island : summary.islands) {
    if (island.id != action.target) continue;
    if (action.kind == Kind::kWeld) island.relaxed = 0;
    if (action.kind != Kind::kAdjust) continue;
    island.needs_adjustment = island.dirty = false;
    island.displaced = island.moved = island.overlaps_since_adjustment = 0;
  }
}

}  // namespace

FusionRequestCounts CountRequests(FusionSummary summary, const PolicyLimits& limits) {
  FusionRequestCounts counts;
  // Queries are taken one by one, so that their number is that of the requests.
  counts.verify = summary.queries;
  summary.graph_lane_busy = summary.adjustment_lane_busy = false;
  while (true) {
    bool changed = false;
    for (const FusionAction& action : DecideActions(summary, limits)) {
      if (action.kind == Kind::kQuery) continue;
      ++CountOf(action.kind, counts);
      TakeAsDone(action, summary);
      changed = true;
    }
    if (!changed) return counts;
  }
}

void TakeOne(FusionAction::Kind kind, FusionRequestCounts& counts) {
  size_t& count = CountOf(kind, counts);
  count -= std::min<size_t>(count, 1);
}

}  // namespace corbslam::map_store

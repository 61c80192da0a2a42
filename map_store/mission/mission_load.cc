#include "map_store/mission/mission_load.h"

#include <algorithm>
#include <utility>

#include "map_store/mission/mission.h"
#include "map_store/view/answers.h"

namespace corbslam::map_store {
namespace {

using Kind = FusionAction::Kind;

size_t& CountOf(Kind kind, FusionRequestCounts& counts) {
  if (kind == Kind::kQuery) return counts.verify;
  return kind == Kind::kAdjust ? counts.adjust : counts.fuse;
}

// As if the action were done, without what would follow from it.
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
  // Queries are taken one by one: their number says it all.
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

MissionInfo Mission::Info() const {
  MissionInfo info = WithState(DescribeMission);
  info.fusion_idle = IsFusionIdle();
  return info;
}

MissionLoad Mission::Load() const {
  absl::ReaderMutexLock lock(&mutex_);
  MissionLoad load;
  load.mission = name_;
  load.revision = state_.global.revision;
  load.agents = state_.agents.size();
  for (const auto& [name, agent] : state_.agents) load.connected_agents += agent.session != 0;
  load.local_maps = state_.local_maps.size();
  load.islands = state_.global.islands.size();
  for (const auto& [id, local_map] : state_.local_maps) {
    load.keyframes += local_map.map.keyframes().size();
    load.map_points += local_map.map.points().size();
  }
  load.overlaps_queried = state_.statistics.overlaps_queried;
  load.overlaps_verified = state_.statistics.overlaps_verified;
  load.overlaps_accepted = state_.statistics.overlaps_accepted;
  load.failed_requests = state_.statistics.failed_requests;
  if (deleted_ || !environment_.has_worker) return load;
  load.waiting = CountRequests(Summarise(), Limits());
  for (const Lane& lane : lanes_) {
    if (!lane.busy) continue;
    // Until it is committed, the state still asks for it.
    size_t& waiting = CountOf(lane.kind, load.waiting);
    waiting -= std::min<size_t>(waiting, 1);
  }
  return load;
}

}  // namespace corbslam::map_store

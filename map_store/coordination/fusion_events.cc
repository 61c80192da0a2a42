#include "map_store/coordination/fusion_events.h"

#include <set>
#include <string>

namespace corbslam::map_store {
namespace {

MissionEvent::IslandsMerged DescribeMerge(const FuseRecord& record, const MissionState& state) {
  MissionEvent::IslandsMerged merged;
  merged.local_maps = state.global.islands.at(record.plan.target).local_maps;
  std::set<std::string> agents;
  for (const LocalMapId& id : merged.local_maps) agents.insert(state.FindLocalMap(id)->agent);
  merged.agents = {agents.begin(), agents.end()};
  merged.ms = record.merge_ms;
  return merged;
}

}  // namespace

std::vector<MissionEvent::OverlapAccepted> ListAcceptedFrom(uint64_t first,
                                                            const MissionState& state) {
  std::vector<MissionEvent::OverlapAccepted> accepted;
  const auto& entries = state.global.overlaps.entries();
  for (auto it = entries.lower_bound(first); it != entries.end(); ++it) {
    const Overlap& overlap = it->second.overlap;
    if (!overlap.IsAccepted()) continue;
    accepted.push_back({it->first, overlap.query.local_map, overlap.candidate.local_map});
  }
  return accepted;
}

MissionEvent::What DescribeFusing(const FuseRecord& record, const MissionState& state) {
  if (record.plan.source.IsValid()) return DescribeMerge(record, state);
  std::set<LocalMapId> joined(record.relaxed.begin(), record.relaxed.end());
  for (const uint64_t id : record.plan.overlaps) {
    const Overlap& overlap = state.global.overlaps.at(id).overlap;
    joined.insert({overlap.query.local_map, overlap.candidate.local_map});
  }
  return MissionEvent::LoopClosed{{joined.begin(), joined.end()}, record.plan.overlaps.size()};
}

MissionEvent::MapAdjusted DescribeAdjustment(const AdjustRecord& record, absl::Duration took) {
  return {record.plan.target, static_cast<size_t>(record.statistics.keyframes),
          static_cast<size_t>(record.statistics.map_points), absl::ToDoubleMilliseconds(took)};
}

}  // namespace corbslam::map_store

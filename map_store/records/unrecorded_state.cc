#include "map_store/records/unrecorded_state.h"

#include <utility>

namespace corbslam::map_store {

UnrecordedState CopyUnrecorded(const MissionState& state) {
  UnrecordedState unrecorded;
  for (const auto& [name, agent] : state.agents) unrecorded.agents[name] = agent.local_maps;
  unrecorded.queries = state.queries;
  unrecorded.overlaps = state.global.overlaps;
  unrecorded.islands = state.global.islands;
  unrecorded.version = state.version;
  unrecorded.statistics = state.statistics;
  return unrecorded;
}

void PutUnrecorded(UnrecordedState unrecorded, MissionState& state) {
  for (auto& [name, local_maps] : unrecorded.agents) {
    state.agents[name].local_maps = std::move(local_maps);
  }
  state.queries = std::move(unrecorded.queries);
  state.global.overlaps = std::move(unrecorded.overlaps);
  state.global.islands = std::move(unrecorded.islands);
  state.version = unrecorded.version;
  state.statistics = std::move(unrecorded.statistics);
}

}  // namespace corbslam::map_store

#include "map_store/joining/joining_choice.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace corbslam::map_store {
namespace {

// A fused local map of a metric camera has the unit of its island up to rounding.
constexpr double kSameUnit = 1e-6;

const Similarity3d* FindMetricFrame(LocalMapId id, const GlobalLayer& global) {
  const auto it = global.island_from_local.find(id);
  if (it == global.island_from_local.end()) return nullptr;
  return std::abs(it->second.scale - 1) > kSameUnit ? nullptr : &it->second;
}

// Returns the agent's closed local maps but the newest ones, in the order of arrival.
std::vector<LocalMapId> ListOld(const MissionState& state, const AgentState& agent, size_t kept) {
  std::vector<LocalMapId> closed;
  for (const LocalMapId& id : agent.local_maps) {
    if (state.FindLocalMap(id)->closed) closed.push_back(id);
  }
  closed.resize(closed.size() - std::min(closed.size(), kept));
  return closed;
}

std::optional<LocalMapJoining> Try(LocalMapId part, LocalMapId whole, const MissionState& state) {
  const Similarity3d* island_from_part = FindMetricFrame(part, state.global);
  const Similarity3d* island_from_whole = FindMetricFrame(whole, state.global);
  if (island_from_part == nullptr || island_from_whole == nullptr) return std::nullopt;
  const LocalMapJoining joining{
      part, whole, island_from_whole->ToRigid().Inverse() * island_from_part->ToRigid()};
  if (!CheckMayJoin(joining, state).ok()) return std::nullopt;
  return joining;
}

std::optional<LocalMapJoining> ChooseOf(const std::vector<LocalMapId>& old,
                                        const MissionState& state) {
  for (size_t i = 1; i < old.size(); ++i) {
    if (FindMetricFrame(old[i], state.global) == nullptr) continue;
    for (size_t earlier = 0; earlier < i; ++earlier) {
      if (state.FindIslandOf(old[earlier]) != state.FindIslandOf(old[i])) continue;
      if (const auto joining = Try(old[i], old[earlier], state)) return joining;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<LocalMapJoining> ChooseJoining(const MissionState& state, size_t kept) {
  for (const auto& [name, agent] : state.agents) {
    if (const auto joining = ChooseOf(ListOld(state, agent, kept), state)) return joining;
  }
  return std::nullopt;
}

}  // namespace corbslam::map_store

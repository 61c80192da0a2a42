#include "map_store/joining/joining_choice.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/hash/hash.h"

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
  const Similarity3d& island_from_part = *FindMetricFrame(part, state.global);
  const Similarity3d& island_from_whole = *FindMetricFrame(whole, state.global);
  const LocalMapJoining joining{part, whole,
                                island_from_whole.ToRigid().Inverse() * island_from_part.ToRigid()};
  if (!CheckMayJoin(joining, state).ok()) return std::nullopt;
  return joining;
}

// Looks through one agent's old local maps, the earliest first.
class Search {
 public:
  Search(const MissionState& state, JoiningMemory& memory) : state_(state), memory_(memory) {}

  // Returns the joining of the local map with an earlier one of those that this was called with.
  std::optional<LocalMapJoining> Next(LocalMapId id) {
    if (FindMetricFrame(id, state_.global) == nullptr) return std::nullopt;
    const LocalMapState& local_map = state_.local_maps.at(id);
    if (IsKeptApart(local_map, state_.global)) return std::nullopt;
    LocalMapId* const whole = FindWhole(local_map);
    if (whole == nullptr || !MayBecomePart(local_map, state_).ok()) return std::nullopt;
    if (!Stands(state_.local_maps.at(*whole))) {
      *whole = id;
      return std::nullopt;
    }
    return Stands(local_map) ? Try(id, *whole, state_) : std::nullopt;
  }

 private:
  // Local maps of one island whose cameras look alike at first sight.
  using Kind = std::pair<IslandId, size_t>;

  Kind KindOf(const LocalMapState& local_map) const {
    size_t looks = local_map.cameras.size();
    for (const auto& camera : local_map.cameras) {
      looks = absl::HashOf(looks, camera->fx_px, camera->fy_px, camera->cx_px, camera->cy_px);
    }
    return {state_.FindIslandOf(local_map.id)->id, looks};
  }

  // Returns the earliest one with the same island and cameras that is not known to be unfit; null
  // if there is none, and then it is this one for those behind.
  LocalMapId* FindWhole(const LocalMapState& local_map) {
    std::vector<LocalMapId>& alike = wholes_[KindOf(local_map)];
    for (LocalMapId& whole : alike) {
      if (HaveSameCameras(state_.local_maps.at(whole), local_map)) return &whole;
    }
    alike.push_back(local_map.id);
    return nullptr;
  }

  bool Stands(const LocalMapState& local_map) {
    const uint64_t revision = state_.global.revision;
    const size_t keyframes = local_map.map.keyframes().size();
    const auto known = memory_.trees.find(local_map.id);
    if (known != memory_.trees.end() && known->second.revision == revision &&
        known->second.keyframes == keyframes) {
      return known->second.stand;
    }
    ++memory_.walked;
    const bool stand = StandsByItself(local_map, state_.global);
    memory_.trees[local_map.id] = {revision, keyframes, stand};
    return stand;
  }

  const MissionState& state_;
  JoiningMemory& memory_;
  absl::flat_hash_map<Kind, std::vector<LocalMapId>> wholes_;  // Of different cameras each.
};

}  // namespace

std::optional<LocalMapJoining> ChooseJoining(const MissionState& state, size_t kept,
                                             JoiningMemory& memory) {
  std::erase_if(memory.trees,
                [&state](const auto& item) { return !state.local_maps.contains(item.first); });
  for (const auto& [name, agent] : state.agents) {
    Search search(state, memory);
    for (const LocalMapId& id : ListOld(state, agent, kept)) {
      if (const auto joining = search.Next(id)) return joining;
    }
  }
  return std::nullopt;
}

std::optional<LocalMapJoining> ChooseJoining(const MissionState& state, size_t kept) {
  JoiningMemory none;
  return ChooseJoining(state, kept, none);
}

}  // namespace corbslam::map_store

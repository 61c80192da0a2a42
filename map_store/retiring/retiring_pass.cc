#include "map_store/retiring/retiring_pass.h"

#include <algorithm>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "map_store/retiring/fading.h"
#include "map_store/retiring/landmark_sights.h"

namespace corbslam::map_store {
namespace {

// Around so many keyframes of a drive there are a few hundred of all sessions.
constexpr size_t kKeyframesOfStretch = 24;
// Taking a keyframe out of the graph takes a millisecond or two.
constexpr size_t kKeyframesOfPart = 4;
constexpr size_t kPointsOfPart = 500;

size_t CountClosed(const MissionState& state, const Island& island) {
  return static_cast<size_t>(std::ranges::count_if(
      island.local_maps, [&state](LocalMapId id) { return state.FindLocalMap(id)->closed; }));
}

// One session alone needs all that it has.
bool MayRetire(const MissionState& state, const Island& island) {
  return island.fused && island.local_maps.size() >= 2 && CountClosed(state, island) >= 2;
}

RetiringStretch MakeStretch(const LocalMapState& local_map, const Island& island, size_t begin) {
  RetiringStretch stretch{local_map.id, island.id, {}, begin};
  for (; stretch.end < local_map.arrived.size(); ++stretch.end) {
    if (stretch.keyframes.size() == kKeyframesOfStretch) break;
    const KeyframeId id = local_map.arrived[stretch.end];
    if (local_map.map.FindKeyframe(id) != nullptr) stretch.keyframes.insert(id);
  }
  return stretch;
}

}  // namespace

std::optional<size_t> RetiringPasses::BeginOf(const LocalMapState& local_map,
                                              const Island& island) const {
  if (!local_map.closed) return std::nullopt;
  const auto it = progress_.find(local_map.id);
  const bool is_known = it != progress_.end() && it->second.island == island.id;
  const size_t begin = is_known ? it->second.next : 0;
  if (begin >= local_map.arrived.size()) return std::nullopt;
  return begin;
}

std::optional<RetiringStretch> RetiringPasses::Next(const MissionState& state) const {
  for (const auto& [id, island] : state.global.islands) {
    if (!MayRetire(state, island)) continue;
    for (const LocalMapId& member : island.local_maps) {
      const LocalMapState& local_map = *state.FindLocalMap(member);
      const std::optional<size_t> begin = BeginOf(local_map, island);
      if (begin.has_value()) return MakeStretch(local_map, island, *begin);
    }
  }
  return std::nullopt;
}

bool RetiringPasses::IsDue(const MissionState& state) const {
  for (const auto& [id, island] : state.global.islands) {
    if (!MayRetire(state, island)) continue;
    for (const LocalMapId& member : island.local_maps) {
      if (BeginOf(*state.FindLocalMap(member), island).has_value()) return true;
    }
  }
  return false;
}

void RetiringPasses::NoteDone(const RetiringStretch& stretch) {
  progress_[stretch.local_map] = {stretch.island, stretch.end};
}

void RetiringPasses::NoteAllDone(const MissionState& state) {
  for (const auto& [id, island] : state.global.islands) {
    if (!MayRetire(state, island)) continue;
    for (const LocalMapId& member : island.local_maps) {
      const LocalMapState& local_map = *state.FindLocalMap(member);
      if (local_map.closed) progress_[member] = {id, local_map.arrived.size()};
    }
  }
}

std::vector<Retirement> CutIntoParts(const Retirement& retirement) {
  std::vector<Retirement> parts;
  for (size_t i = 0; i < retirement.faded.size(); ++i) {
    if (i % kPointsOfPart == 0) parts.emplace_back();
    parts.back().faded.push_back(retirement.faded[i]);
  }
  for (size_t i = 0; i < retirement.keyframes.size(); ++i) {
    if (i % kKeyframesOfPart == 0) parts.emplace_back();
    parts.back().keyframes.push_back(retirement.keyframes[i]);
  }
  return parts;
}

Retirement PlanRetirement(const RetiringView& view, const MapStoreOptions& options,
                          StayCounts* stays) {
  Retirement retirement;
  const SightsOfLandmarks sights = FindSights(view, {});
  const std::vector<MapPointId> vanished = FindFaded(view, sights, {});
  for (const MapPointId& landmark : vanished) {
    const std::vector<MapPointId>& members = view.landmarks.at(landmark);
    retirement.faded.insert(retirement.faded.end(), members.begin(), members.end());
  }
  ChoiceOptions choice;
  choice.seen_share = options.retire_share;
  const absl::flat_hash_set<MapPointId> faded(vanished.begin(), vanished.end());
  retirement.keyframes = ChooseKeyframes(view, sights, faded, choice, stays);
  return retirement;
}

}  // namespace corbslam::map_store

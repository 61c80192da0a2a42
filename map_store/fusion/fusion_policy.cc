#include "map_store/fusion/fusion_policy.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <tuple>
#include <utility>

namespace corbslam::map_store {
namespace {

using IslandSummary = FusionSummary::IslandSummary;
using OverlapSummary = FusionSummary::OverlapSummary;

const IslandSummary* Find(const FusionSummary& summary, IslandId id) {
  for (const IslandSummary& island : summary.islands) {
    if (island.id == id) return &island;
  }
  return nullptr;
}

// Returns whether `a` keeps its frame: one in metres does before one that has none, so that both
// have them; then the reference island, then the larger one, then the earlier.
bool KeepsFrame(const IslandSummary& a, const IslandSummary& b) {
  const auto rank = [](const IslandSummary& island) {
    return std::make_tuple(!island.in_metres, island.order != 0,
                           -static_cast<int64_t>(island.keyframes), island.order);
  };
  return rank(a) < rank(b);
}

// Returns the first overlap by itself if it is to be alone, else all that need not be.
std::vector<uint64_t> ChooseTogether(const std::vector<OverlapSummary>& overlaps) {
  std::vector<uint64_t> chosen;
  if (overlaps.empty()) return chosen;
  if (overlaps.front().alone) return {overlaps.front().id};
  for (const OverlapSummary& overlap : overlaps) {
    if (!overlap.alone) chosen.push_back(overlap.id);
  }
  return chosen;
}

// Returns the waiting overlaps between the same islands as `one`.
std::vector<OverlapSummary> FindBeside(const FusionSummary& summary, const OverlapSummary& one) {
  std::vector<OverlapSummary> beside;
  std::ranges::copy_if(summary.waiting, std::back_inserter(beside), [&one](const auto& overlap) {
    return std::minmax(overlap.a, overlap.b) == std::minmax(one.a, one.b);
  });
  return beside;
}

// Returns whether all that is known of how two islands lie to each other is vague, and robots are
// there to be put beside their place by it.
bool IsHeldBack(const FusionSummary& summary, const OverlapSummary& overlap,
                const PolicyLimits& limits) {
  const IslandSummary* a = Find(summary, overlap.a);
  const IslandSummary* b = Find(summary, overlap.b);
  if (overlap.a == overlap.b || a == nullptr || b == nullptr) return false;
  if (a->quiet && b->quiet && summary.queries == 0) return false;
  const std::vector<OverlapSummary> beside = FindBeside(summary, overlap);
  return beside.size() < limits.vague_to_fuse &&
         std::ranges::all_of(beside, &OverlapSummary::vague);
}

std::optional<FusionAction> DecideFuse(const FusionSummary& summary, const PolicyLimits& limits) {
  for (const OverlapSummary& first : summary.waiting) {
    if (first.a == first.b || IsHeldBack(summary, first, limits)) continue;
    const IslandSummary* a = Find(summary, first.a);
    const IslandSummary* b = Find(summary, first.b);
    if (a == nullptr || b == nullptr) continue;
    if (!KeepsFrame(*a, *b)) std::swap(a, b);
    return FusionAction{FusionAction::Kind::kFuse, a->id, b->id,
                        ChooseTogether(FindBeside(summary, first))};
  }
  return std::nullopt;
}

// Returns whether the island's adjustment is not to be cancelled once more.
bool IsLetEnd(const IslandSummary& island, const PolicyLimits& limits) {
  return island.adjusting && island.cancelled_adjustments >= limits.max_cancelled_adjustments;
}

bool AreEnough(const IslandSummary& island, size_t overlaps, const PolicyLimits& limits) {
  return overlaps >= limits.weld_every &&
         static_cast<double>(overlaps) >= limits.weld_share * static_cast<double>(island.keyframes);
}

std::optional<FusionAction> DecideWeld(const FusionSummary& summary, const PolicyLimits& limits) {
  for (const IslandSummary& island : summary.islands) {
    if (IsLetEnd(island, limits)) continue;
    std::vector<OverlapSummary> inside;
    bool urgent = island.relaxed > 0;
    for (const OverlapSummary& overlap : summary.waiting) {
      if (overlap.a != island.id || overlap.b != island.id) continue;
      inside.push_back(overlap);
      urgent = urgent || overlap.urgent || overlap.alone;
    }
    const bool last = island.quiet && summary.queries == 0 && !inside.empty();
    if (urgent || last || AreEnough(island, inside.size(), limits)) {
      return FusionAction{FusionAction::Kind::kWeld, island.id, {}, ChooseTogether(inside)};
    }
  }
  return std::nullopt;
}

// Returns whether the graph lane has work that will change the island.
bool IsAboutToChange(const FusionSummary& summary, const IslandSummary& island,
                     const PolicyLimits& limits) {
  if (island.relaxed > 0) return true;
  return std::any_of(
      summary.waiting.begin(), summary.waiting.end(), [&](const OverlapSummary& overlap) {
        const bool touches = overlap.a == island.id || overlap.b == island.id;
        return touches && (overlap.a != overlap.b || overlap.urgent || overlap.alone) &&
               !IsHeldBack(summary, overlap, limits);
      });
}

// Returns whether enough has changed since the last adjustment. New keyframes alone follow the ones
// before them as well as an adjustment could have it; with overlaps since there is something to
// adjust them to.
bool HasChangedEnough(const IslandSummary& island, const PolicyLimits& limits) {
  size_t changed = island.displaced + island.moved;
  if (island.overlaps_since_adjustment > 0) changed += island.new_keyframes;
  const double share = limits.adjust_share * static_cast<double>(island.keyframes);
  return changed >= limits.adjust_min_keyframes && static_cast<double>(changed) >= share;
}

std::optional<FusionAction> DecideAdjust(const FusionSummary& summary, const PolicyLimits& limits) {
  for (const IslandSummary& island : summary.islands) {
    if (!island.fused || IsAboutToChange(summary, island, limits)) continue;
    const bool waits = std::ranges::any_of(summary.waiting, [&](const OverlapSummary& o) {
      return (o.a == island.id || o.b == island.id) && !IsHeldBack(summary, o, limits);
    });
    const bool last = island.quiet && island.dirty && summary.queries == 0 && !waits;
    if (last || island.needs_adjustment || HasChangedEnough(island, limits)) {
      return FusionAction{FusionAction::Kind::kAdjust, island.id, {}, {}};
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<FusionAction> DecideActions(const FusionSummary& summary, const PolicyLimits& limits) {
  std::vector<FusionAction> actions;
  if (!summary.graph_lane_busy) {
    std::optional<FusionAction> action = DecideFuse(summary, limits);
    if (!action.has_value()) action = DecideWeld(summary, limits);
    if (!action.has_value() && summary.queries > 0) {
      action = FusionAction{FusionAction::Kind::kQuery, {}, {}, {}};
    }
    if (action.has_value()) actions.push_back(*std::move(action));
  }
  if (!summary.adjustment_lane_busy) {
    if (auto action = DecideAdjust(summary, limits)) actions.push_back(*std::move(action));
  }
  return actions;
}

}  // namespace corbslam::map_store

#include "map_store/ingest/parked_references.h"

#include <optional>
#include <variant>

#include "map_store/ingest/graph_changes.h"

namespace corbslam::map_store {
namespace {

std::optional<MissingItem> Apply(const ParkedReference& parked, MissionState& state,
                                 LocalMapState& local_map) {
  if (const auto* change = std::get_if<ObservationChange>(&parked.reference)) {
    return ApplyObservation(*change, state, local_map);
  }
  return ApplyLoopEdge(std::get<LoopEdge>(parked.reference), state, local_map);
}

}  // namespace

void TakeReference(const ParkedReference& reference, MissionState& state,
                   LocalMapState& local_map) {
  const std::optional<MissingItem> missing = Apply(reference, state, local_map);
  if (missing.has_value()) local_map.parked.Put(local_map.parked.NextKey(), reference, *missing);
}

void TakeParent(KeyframeId child, KeyframeId parent, LocalMapState& local_map) {
  local_map.parked_parents.Erase(child);
  const std::optional<MissingItem> missing = ApplyParent(child, parent, local_map);
  if (missing.has_value()) local_map.parked_parents.Put(child, {parent}, *missing);
}

void RetryParked(MissionState& state, LocalMapState& local_map) {
  for (const auto& [child, parked] : local_map.parked_parents.TakeDue()) {
    const std::optional<MissingItem> missing = ApplyParent(child, parked.parent, local_map);
    if (missing.has_value()) local_map.parked_parents.Put(child, parked, *missing);
  }
  for (const auto& [order, parked] : local_map.parked.TakeDue()) {
    const std::optional<MissingItem> missing = Apply(parked, state, local_map);
    if (missing.has_value()) local_map.parked.Put(order, parked, *missing);
  }
}

void ExpireParked(absl::Time now, const MapStoreOptions& options, LocalMapState& local_map) {
  const absl::Duration limit = absl::Seconds(options.max_parked_s);
  local_map.expired_references += local_map.parked.Expire(now, limit);
  local_map.expired_references += local_map.parked_parents.Expire(now, limit);
}

}  // namespace corbslam::map_store

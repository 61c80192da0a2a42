#include "map_store/ingest/parked_references.h"

#include <deque>
#include <map>
#include <utility>

#include "map_store/ingest/graph_changes.h"

namespace corbslam::map_store {
namespace {

bool TryParked(const ParkedReference& parked, MissionState& state, LocalMapState& local_map) {
  if (const auto* change = std::get_if<ObservationChange>(&parked.reference)) {
    return ApplyObservation(*change, state, local_map);
  }
  return ApplyLoopEdge(std::get<LoopEdge>(parked.reference), state, local_map);
}

// The first look at something that waits notes when that was.
bool IsExpired(absl::Time now, absl::Duration limit, absl::Time& since) {
  if (since == absl::InfiniteFuture()) since = now;
  return now - since > limit;
}

}  // namespace

void Park(const ObservationChange& change, LocalMapState& local_map) {
  local_map.parked.push_back({change});
}

void Park(const LoopEdge& edge, LocalMapState& local_map) { local_map.parked.push_back({edge}); }

void TakeParent(KeyframeId child, KeyframeId parent, LocalMapState& local_map) {
  local_map.parked_parents.erase(child);
  if (ApplyParent(child, parent, local_map)) return;
  local_map.parked_parents[child] = {parent};
}

void RetryParked(MissionState& state, LocalMapState& local_map) {
  std::erase_if(local_map.parked_parents, [&](const auto& entry) {
    return ApplyParent(entry.first, entry.second.parent, local_map);
  });
  std::deque<ParkedReference> waiting;
  waiting.swap(local_map.parked);
  for (ParkedReference& parked : waiting) {
    if (!TryParked(parked, state, local_map)) local_map.parked.push_back(std::move(parked));
  }
}

void ExpireParked(absl::Time now, const MapStoreOptions& options, LocalMapState& local_map) {
  const absl::Duration limit = absl::Seconds(options.max_parked_s);
  const auto is_expired = [&](auto& parked) { return IsExpired(now, limit, parked.since); };
  local_map.expired_references +=
      std::erase_if(local_map.parked, [&](ParkedReference& parked) { return is_expired(parked); });
  for (auto it = local_map.parked_parents.begin(); it != local_map.parked_parents.end();) {
    const bool expired = is_expired(it->second);
    local_map.expired_references += expired ? 1 : 0;
    it = expired ? local_map.parked_parents.erase(it) : std::next(it);
  }
}

}  // namespace corbslam::map_store

#include "map_store/fusion/overlap_units.h"

#include <optional>

#include "map_store/view/metres.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

// Returns how many units of its owner's local map a unit of the keyframe's island is; nullopt where
// nobody knows the keyframe.
std::optional<double> OwnersPerIslands(const MissionState& state, KeyframeId id) {
  const LocalMapState* const local_map = state.FindLocalMap(id.local_map);
  if (local_map == nullptr || local_map->map.FindKeyframe(id) == nullptr) return std::nullopt;
  if (IsInMetres(*local_map)) return 1;
  return FindPoses(state, *local_map)->poses.at(id).scale;
}

// Multiplies the units of the query's camera and of the candidate's.
void Rescale(double query, double candidate, Overlap& overlap) {
  if (query == 1 && candidate == 1) return;
  overlap.candidate_from_query.scale *= candidate / query;
  overlap.candidate_from_query.translation *= candidate;
  overlap.covariance.topRows<3>() *= candidate;
  overlap.covariance.leftCols<3>() *= candidate;
}

}  // namespace

void ToOwnersUnits(const MissionState& state, Overlap& overlap) {
  const auto query = OwnersPerIslands(state, overlap.query);
  const auto candidate = OwnersPerIslands(state, overlap.candidate);
  if (query.has_value() && candidate.has_value()) Rescale(*query, *candidate, overlap);
}

void ToIslandsUnits(const MissionState& state, Overlap& overlap) {
  const auto query = OwnersPerIslands(state, overlap.query);
  const auto candidate = OwnersPerIslands(state, overlap.candidate);
  if (query.has_value() && candidate.has_value()) Rescale(1 / *query, 1 / *candidate, overlap);
}

}  // namespace corbslam::map_store

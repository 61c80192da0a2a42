#include "map_store/fusion/fusion_job.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "map_store/fusion/overlap_query.h"
#include "map_store/fusion/overlap_units.h"
#include "map_store/view/placement.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

const Island* FindIsland(const MissionState& state, IslandId id) {
  const auto it = state.global.islands.find(id);
  return it == state.global.islands.end() ? nullptr : &it->second;
}

bool LiesIn(const MissionState& state, KeyframeId keyframe, const FusionAction& action) {
  const auto it = state.global.island_of.find(keyframe.local_map);
  if (it == state.global.island_of.end()) return false;
  return it->second == action.target || it->second == action.source;
}

bool LiesIn(const MissionState& state, const Overlap& overlap, const FusionAction& action) {
  return LiesIn(state, overlap.query, action) && LiesIn(state, overlap.candidate, action);
}

bool Touches(const MissionState& state, const Overlap& overlap,
             const std::vector<LocalMapId>& local_maps) {
  return std::any_of(local_maps.begin(), local_maps.end(), [&](LocalMapId id) {
    return state.OwnerOf(overlap.query.local_map) == id ||
           state.OwnerOf(overlap.candidate.local_map) == id;
  });
}

// Returns how far apart the overlap and the present placing of its keyframes are.
double Disagreement(const MissionState& state, const Overlap& overlap) {
  const auto query = state.global.keyframes.find(overlap.query);
  const auto candidate = state.global.keyframes.find(overlap.candidate);
  const bool placed =
      query != state.global.keyframes.end() && candidate != state.global.keyframes.end();
  if (!placed) return std::numeric_limits<double>::max();
  const Similarity3d error = overlap.candidate_from_query * query->second.camera_from_island *
                             candidate->second.camera_from_island.Inverse();
  return error.translation.norm() + RotationAngle(error.rotation);
}

// A local map that bent itself is held to its island by the overlaps that it already has: of them,
// the one that agrees best with the graph calls for the work again. Others may have been outvoted.
void CallAgain(const MissionState& state, const std::vector<LocalMapId>& relaxed,
               FuseMapsRequest& request) {
  if (!request.new_overlaps.empty()) return;
  std::optional<size_t> best;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < request.overlaps.size(); ++i) {
    if (!Touches(state, request.overlaps[i], relaxed)) continue;
    const double disagreement = Disagreement(state, request.overlaps[i]);
    if (disagreement >= least) continue;
    least = disagreement;
    best = i;
  }
  if (best.has_value()) request.new_overlaps.push_back(*best);
}

// Collects all overlaps in the graph of both islands, and those that are to join it.
void CollectOverlaps(const MissionState& state, const FusionAction& action, FuseJob& job) {
  FuseMapsRequest& request = job.request;
  const std::set<uint64_t> called_for(action.overlaps.begin(), action.overlaps.end());
  OverlapLedger::Ids ids = state.global.overlaps.in_graph();
  ids.insert(called_for.begin(), called_for.end());
  for (const uint64_t id : ids) {
    const bool is_new = called_for.contains(id);
    const OverlapEntry& entry = state.global.overlaps.at(id);
    if (!LiesIn(state, entry.overlap, action)) continue;
    // The living relatives of removed keyframes may be in another robot's map, and elsewhere.
    std::optional<Overlap> overlap = ChainOverlap(state, entry.overlap);
    if (!overlap.has_value() || !LiesIn(state, *overlap, action)) continue;
    if (is_new) {
      request.new_overlaps.push_back(request.overlaps.size());
      job.new_overlaps.push_back(id);
    }
    request.overlaps.push_back(*std::move(overlap));
  }
}

// Returns the keyframes of the overlaps that call for the work.
std::set<KeyframeId> CentresOf(const FuseMapsRequest& request) {
  std::set<KeyframeId> centres;
  for (const size_t index : request.new_overlaps) {
    centres.insert(request.overlaps[index].query);
    centres.insert(request.overlaps[index].candidate);
  }
  return centres;
}

std::set<MapPointId> PointsOf(const std::vector<Overlap>& overlaps) {
  std::set<MapPointId> points;
  for (const Overlap& overlap : overlaps) {
    for (const PointPair& pair : overlap.inliers) points.insert({pair.query, pair.candidate});
  }
  return points;
}

// Drops pairs whose points have gone from the views: they say nothing. Pairs that fusion has made
// one point since still say how far away the scene is.
void DropIdlePairs(FuseMapsRequest& request) {
  const auto is_there = [&request](MapPointId id) {
    return request.target.FindPoint(id) != nullptr || request.source.FindPoint(id) != nullptr;
  };
  for (Overlap& overlap : request.overlaps) {
    std::erase_if(overlap.inliers, [&is_there](const PointPair& pair) {
      return !is_there(pair.query) || !is_there(pair.candidate);
    });
  }
}

// Returns whether the views hold the overlaps' keyframes: owners may have removed some while the
// views were built.
bool HoldsOverlaps(const FuseMapsRequest& request) {
  const auto is_there = [&request](KeyframeId id) {
    return request.target.FindKeyframe(id) != nullptr || request.source.FindKeyframe(id) != nullptr;
  };
  return std::ranges::all_of(request.overlaps, [&is_there](const Overlap& overlap) {
    return is_there(overlap.query) && is_there(overlap.candidate);
  });
}

bool IsMetric(const MissionState& state, const IslandSnapshot& snapshot) {
  for (const auto& [id, keyframe] : snapshot.view.keyframes()) {
    if (!keyframe.camera().IsMetric()) return false;
  }
  return state.global.islands.contains(snapshot.island);
}

absl::StatusOr<std::optional<FusionRequest>> PrepareFuse(const MissionState& state,
                                                         const FusionAction& action,
                                                         const MapStoreOptions& options,
                                                         LongRead& read) {
  const Island* target = FindIsland(state, action.target);
  const Island* source = FindIsland(state, action.source);
  const bool weld = action.kind == FusionAction::Kind::kWeld;
  if (target == nullptr || (!weld && (source == nullptr || source == target))) return std::nullopt;
  FuseJob job;
  job.action = action;
  Unplaced unplaced = target->displaced;
  if (weld) {
    for (const LocalMapId& id : target->relaxed) {
      unplaced.merge(FindRelaxedKeyframes(state, *target, id));
      job.relaxed.push_back(id);
    }
  }
  CollectOverlaps(state, action, job);
  CallAgain(state, job.relaxed, job.request);
  for (Overlap& overlap : job.request.overlaps) ToIslandsUnits(state, overlap);
  // Without new overlaps, the keyframes that called for the work have gone.
  if (job.request.new_overlaps.empty()) return std::nullopt;
  const std::set<KeyframeId> centres = CentresOf(job.request);
  const std::set<MapPointId> points = PointsOf(job.request.overlaps);
  ASSIGN_OR_RETURN(job.target, TakeGraphSnapshot(state, *target, std::move(unplaced), centres,
                                                 options.neighbourhood, points, read));
  job.request.fix_scale = IsMetric(state, job.target);
  if (!weld) {
    ASSIGN_OR_RETURN(job.source, TakeGraphSnapshot(state, *source, source->displaced, centres,
                                                   options.neighbourhood, points, read));
    job.request.fix_scale = job.request.fix_scale && IsMetric(state, *job.source);
    job.request.source = std::move(job.source->view);
  }
  job.request.base_revision = state.global.revision;
  job.request.mission = state.name;
  job.request.target = std::move(job.target.view);
  if (!HoldsOverlaps(job.request)) return absl::AbortedError("a keyframe of an overlap has gone");
  DropIdlePairs(job.request);
  return FusionRequest(std::move(job));
}

absl::StatusOr<std::optional<FusionRequest>> PrepareAdjust(const MissionState& state,
                                                           const FusionAction& action,
                                                           const MapStoreOptions& options,
                                                           LongRead& read) {
  const Island* island = FindIsland(state, action.target);
  if (island == nullptr) return std::nullopt;
  AdjustJob job;
  // With the whole island in view, the adjustment decides anew which observations are wrong.
  ASSIGN_OR_RETURN(job.snapshot,
                   TakeWholeSnapshot(state, *island, island->displaced, Rejected::kTryAgain, read));
  const Map& view = job.snapshot.view;
  if (view.keyframes().size() < 2) return std::nullopt;
  // The first keyframe of the local map whose frame the island has holds that frame.
  auto fixed = view.keyframes().lower_bound(KeyframeId{island->id, 0});
  if (fixed == view.keyframes().end()) fixed = view.keyframes().begin();
  job.request.fixed = {fixed->first};
  job.request.base_revision = state.global.revision;
  job.request.mission = state.name;
  job.request.max_iterations =
      IsQuiet(state, *island) ? options.last_adjust_iterations : options.adjust_iterations;
  job.request.redundant_share = options.cull_share;
  job.request.target_keyframes = options.cull_target;
  job.request.threads = options.deterministic ? 1 : options.adjust_threads;
  job.request.view = std::move(job.snapshot.view);
  return FusionRequest(std::move(job));
}

}  // namespace

bool IsQuiet(const MissionState& state, const Island& island) {
  return std::ranges::all_of(island.local_maps, [&state](LocalMapId id) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    return local_map.closed || state.agents.at(local_map.agent).session == 0;
  });
}

std::optional<Overlap> ChainOverlap(const MissionState& state, const Overlap& overlap) {
  LivingRelative query;
  LivingRelative candidate;
  if (!FindLivingRelative(state, overlap.query, query)) return std::nullopt;
  if (!FindLivingRelative(state, overlap.candidate, candidate)) return std::nullopt;
  if (query.id == candidate.id) return std::nullopt;
  Overlap chained = overlap;
  chained.query = query.id;
  chained.candidate = candidate.id;
  chained.candidate_from_query = Similarity3d::FromRigid(candidate.relative_from_id) *
                                 overlap.candidate_from_query *
                                 Similarity3d::FromRigid(query.relative_from_id.Inverse());
  const Matrix7d A = AdjointSim3(Similarity3d::FromRigid(candidate.relative_from_id));
  chained.covariance = A * overlap.covariance * A.transpose();
  chained.inliers.clear();
  for (const PointPair& pair : overlap.inliers) {
    const PointPair living = {ResolvePoint(state, pair.query), ResolvePoint(state, pair.candidate)};
    if (living.query.IsValid() && living.candidate.IsValid()) chained.inliers.push_back(living);
  }
  return chained;
}

Unplaced FindRelaxedKeyframes(const MissionState& state, const Island& island,
                              LocalMapId local_map_id) {
  const LocalMapState& local_map = *state.FindLocalMap(local_map_id);
  Unplaced placed;
  for (const auto& [id, keyframe] : local_map.map.keyframes()) {
    if (state.global.keyframes.contains(id)) placed.insert(id);
  }
  if (placed.empty()) return placed;
  KeyframeId anchor = *placed.begin();
  if (local_map_id != island.id) {
    for (const uint64_t id : state.global.overlaps.in_graph()) {
      const Overlap& overlap = state.global.overlaps.at(id).overlap;
      const LocalMapId query = state.OwnerOf(overlap.query.local_map);
      if (query == state.OwnerOf(overlap.candidate.local_map)) continue;
      const KeyframeId own = query == local_map_id ? overlap.query : overlap.candidate;
      if (!placed.contains(own)) continue;
      anchor = own;
      break;
    }
  }
  placed.erase(anchor);
  return placed;
}

absl::StatusOr<std::optional<FusionRequest>> PrepareRequest(const MissionState& state,
                                                            const FusionAction& action,
                                                            const MapStoreOptions& options,
                                                            LongRead& read, QueryViews& views) {
  switch (action.kind) {
    case FusionAction::Kind::kQuery: {
      if (state.queries.empty()) return std::nullopt;
      const QueryTask task = state.queries.front();
      ASSIGN_OR_RETURN(auto request, BuildVerifyRequest(state, task, options, read, views));
      if (!request.has_value()) return std::nullopt;
      return FusionRequest(QueryJob{task, *std::move(request)});
    }
    case FusionAction::Kind::kFuse:
    case FusionAction::Kind::kWeld:
      return PrepareFuse(state, action, options, read);
    case FusionAction::Kind::kAdjust:
      return PrepareAdjust(state, action, options, read);
  }
  return std::nullopt;
}

absl::StatusOr<FusionResult> RunRequest(const FusionRequest& work, FusionWorker& worker,
                                        const ProgressCallback& progress) {
  if (const auto* query = std::get_if<QueryJob>(&work)) {
    return worker.VerifyOverlap(query->request, progress);
  }
  if (const auto* fuse = std::get_if<FuseJob>(&work)) {
    return worker.FuseMaps(fuse->request, progress);
  }
  return worker.AdjustBundle(std::get<AdjustJob>(work).request, progress);
}

}  // namespace corbslam::map_store

// A job is one piece of work for a fusion worker: the request and what is needed to commit its
// result.
#ifndef CORBSLAM_MAP_STORE_FUSION_FUSION_JOB_H_
#define CORBSLAM_MAP_STORE_FUSION_FUSION_JOB_H_

#include <atomic>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "map_store/fusion/fusion_policy.h"
#include "map_store/fusion/overlap_query.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/island_view.h"
#include "map_store/view/long_read.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::map_store {

struct QueryJob {
  QueryTask task;
  VerifyOverlapRequest request;
};

// A job that fuses two islands, or welds one (then the source is empty).
struct FuseJob {
  FusionAction action;
  FuseMapsRequest request;
  // The overlaps that the request calls new; some of the action's may have lost their keyframes.
  std::vector<uint64_t> new_overlaps;
  // The islands as the request has them, without their views, which have gone into the request.
  IslandSnapshot target;
  std::optional<IslandSnapshot> source;
  std::vector<LocalMapId> relaxed;
};

struct AdjustJob {
  AdjustBundleRequest request;
  // The island without its view, which has gone into the request.
  IslandSnapshot snapshot;
  // When it was begun to be read. Whoever starts the job says so.
  absl::Time begin = absl::InfinitePast();
};

using FusionRequest = std::variant<QueryJob, FuseJob, AdjustJob>;
using FusionResult = std::variant<VerifyOverlapResult, FuseMapsResult, AdjustBundleResult>;

struct FusionJob {
  FusionRequest work;
  // True once the result would be worth nothing any more.
  std::shared_ptr<std::atomic<bool>> cancelled;
};

// Builds the request from the state as it is now. Returns nullopt when it turns out that nothing is
// to be done (the query has no candidates, the islands have gone). ABORTED: the caller starts
// again, with the action that is the next one then.
absl::StatusOr<std::optional<FusionRequest>> PrepareRequest(const MissionState& state,
                                                            const FusionAction& action,
                                                            const MapStoreOptions& options,
                                                            LongRead& read, QueryViews& views);

// Asks the worker and blocks until it answers. The caller holds no lock.
absl::StatusOr<FusionResult> RunRequest(const FusionRequest& work, FusionWorker& worker,
                                        const ProgressCallback& progress);

// Returns whether no robot streams into any of the island's local maps.
bool IsQuiet(const MissionState& state, const Island& island);

// Returns the overlap between the living relatives of its two keyframes; nullopt when either has
// none, or they are one and the same.
std::optional<Overlap> ChainOverlap(const MissionState& state, const Overlap& overlap);

// Returns all placed keyframes of the local map but the one by which it holds to its island: they
// are to be derived anew from the owner's poses after it closed a loop.
Unplaced FindRelaxedKeyframes(const MissionState& state, const Island& island,
                              LocalMapId local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_FUSION_JOB_H_

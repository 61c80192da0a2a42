// One piece of work for a fusion worker: the request and what is needed to commit its result.
#ifndef CORBSLAM_MAP_STORE_FUSION_FUSION_JOB_H_
#define CORBSLAM_MAP_STORE_FUSION_FUSION_JOB_H_

#include <atomic>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/fusion/fusion_policy.h"
#include "map_store/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/island_view.h"
#include "map_store/view/long_read.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::map_store {

struct QueryJob {
  QueryTask task;
  VerifyOverlapRequest request;
};

// Fusing two islands, or (source empty) welding one.
struct FuseJob {
  FusionAction action;
  FuseMapsRequest request;
  // Those that the request calls new; of the action's, some may have lost their keyframes.
  std::vector<uint64_t> new_overlaps;
  // Their views have gone into the request.
  IslandSnapshot target;
  std::optional<IslandSnapshot> source;
  std::vector<LocalMapId> relaxed;
};

struct AdjustJob {
  AdjustBundleRequest request;
  IslandSnapshot snapshot;  // Its view has gone into the request.
};

using FusionRequest = std::variant<QueryJob, FuseJob, AdjustJob>;
using FusionResult = std::variant<VerifyOverlapResult, FuseMapsResult, AdjustBundleResult>;

struct FusionJob {
  FusionRequest work;
  // Set when the result would be worth nothing any more.
  std::shared_ptr<std::atomic<bool>> cancelled;
};

// Builds the request from the state as it is now. None when it turns out that nothing is to be
// done (the query has no candidates, the islands have gone). ABORTED: start again, with the action
// that is the next one then.
absl::StatusOr<std::optional<FusionRequest>> PrepareRequest(const MissionState& state,
                                                            const FusionAction& action,
                                                            const MapStoreOptions& options,
                                                            LongRead& read);

// Asks the worker; blocks. Called without any lock.
absl::StatusOr<FusionResult> RunRequest(const FusionRequest& work, FusionWorker& worker,
                                        const ProgressCallback& progress);

// No robot streams into any of its local maps.
bool IsQuiet(const MissionState& state, const Island& island);

// The overlap between the living relatives of its two keyframes; none when either has none, or
// they are one and the same.
std::optional<Overlap> ChainOverlap(const MissionState& state, const Overlap& overlap);

// All placed keyframes of the local map but the one by which it holds to its island: what is to be
// derived anew from the owner's poses after it closed a loop.
Unplaced FindRelaxedKeyframes(const MissionState& state, const Island& island,
                              LocalMapId local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_FUSION_JOB_H_

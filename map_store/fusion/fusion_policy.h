// Decides what fusion should do next: a pure function of a summary of the mission, so that every
// rule can be tested with a table. It knows nothing of threads, workers or maps.
#ifndef CORBSLAM_MAP_STORE_FUSION_FUSION_POLICY_H_
#define CORBSLAM_MAP_STORE_FUSION_FUSION_POLICY_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "map_store/state/lookups.h"

namespace corbslam::map_store {

struct FusionSummary {
  struct IslandSummary {
    IslandId id;
    size_t order = 0;  // Order in which its first local map arrived; 0: the reference island.
    size_t keyframes = 0;
    bool fused = false;
    bool in_metres = true;  // False: only maps of one camera alone are in it.
    // True: all its local maps are closed or their agents gone.
    bool quiet = false;
    bool dirty = false;
    bool needs_adjustment = false;
    // These four count since the last adjustment: overlaps that joined its graph, keyframes that
    // came, keyframes that their owners moved relative to their parents, and keyframes that
    // overlaps moved.
    size_t overlaps_since_adjustment = 0;
    size_t new_keyframes = 0;
    size_t displaced = 0;
    size_t moved = 0;
    size_t relaxed = 0;
    // True: an adjustment is with a worker, and is not cancelled.
    bool adjusting = false;
    // Number of adjustments cancelled one after the other since the last one that was committed.
    size_t cancelled_adjustments = 0;
  };
  // An accepted overlap that is not in the graph yet.
  struct OverlapSummary {
    uint64_t id = 0;
    IslandId a;
    IslandId b;  // The same as `a`: the overlap is a loop within the island.
    bool urgent = false;
    bool alone = false;  // True: fusing is asked about it by itself.
    bool vague = false;  // IsVague (overlap_vagueness.h).
  };
  std::vector<IslandSummary> islands;   // In the order of arrival.
  std::vector<OverlapSummary> waiting;  // In the order of their ids.
  size_t queries = 0;
  // True: something runs on that lane. Verification and fusing share one: verdicts depend on the
  // graph.
  bool graph_lane_busy = false;
  bool adjustment_lane_busy = false;
};

struct PolicyLimits {
  // Overlaps that agree with an island's graph are welded together when there are at least
  // `weld_every`, and when they are so large a share of its keyframes: welding reads the graph of
  // all of them.
  size_t weld_every = 3;
  double weld_share = 0.01;
  // An adjustment of an island pays when so large a share of its keyframes, and at least so many,
  // has changed: adjusting n keyframes costs as much as n, and so does the sum of all adjustments
  // until then.
  double adjust_share = 0.2;
  size_t adjust_min_keyframes = 20;
  // Vague overlaps between two islands join them when there are so many, or once nobody is there
  // any more whom it could lead astray.
  size_t vague_to_fuse = 3;
  // Welding cancels at most so many adjustments in a row; then it waits until one has ended, or an
  // island into which overlaps come quickly would never be adjusted.
  size_t max_cancelled_adjustments = 2;
};

struct FusionAction {
  enum class Kind {
    kQuery,   // Answers the first query of the queue.
    kFuse,    // Moves `source` into `target`'s frame.
    kWeld,    // Takes overlaps and loop edges inside `target` into its graph.
    kAdjust,  // Runs global bundle adjustment of `target`.
  };
  Kind kind = Kind::kQuery;
  IslandId target;
  IslandId source;
  std::vector<uint64_t> overlaps;
  friend bool operator==(const FusionAction&, const FusionAction&) = default;
};

// Returns at most one action for each idle lane.
std::vector<FusionAction> DecideActions(const FusionSummary& summary, const PolicyLimits& limits);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_FUSION_POLICY_H_

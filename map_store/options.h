// How the map store behaves.
#ifndef CORBSLAM_MAP_STORE_OPTIONS_H_
#define CORBSLAM_MAP_STORE_OPTIONS_H_

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"

namespace corbslam {

struct MapStoreOptions {
  // What changes results.

  // Keyframes of a local map that are provisional: not queried for overlaps and not placed by
  // fusion until this many newer ones have arrived, or the local map is closed. The robot's local
  // adjustment has then moved them as often (docs/adr/0003-settled-keyframes.md).
  size_t settle_after = 3;
  // Others hear of a keyframe when this many newer ones have arrived (0: at once), or the local map
  // is closed; and again when it moves.
  size_t share_after = 0;
  // A candidate must share at least this many words with the query, and this share of what the
  // best one shares.
  int min_shared_words = 10;
  double min_shared_words_ratio = 0.6;
  // Groups of covisible candidates that are verified per query and local map.
  size_t max_candidate_groups = 3;
  // Keyframes around the ends of a new overlap whose points a worker is sent for fusing.
  int neighbourhood = 10;
  // Within this many keyframes of one that has an accepted overlap with the same local map, no
  // further overlap is looked for.
  size_t overlap_spacing = 3;
  // Keyframes of one local map nearer than this in its order are no loop.
  size_t min_loop_gap = 30;
  // Query and candidate that share this many landmarks are linked already, if these agree with the
  // graph to `loop_residual_px`.
  int min_shared_landmarks = 30;
  // An overlap within an island that agrees with the graph to this is not urgent: it is welded
  // together with others when there are `weld_every`, and so large a share of the island's
  // keyframes, or at the end of all streams.
  double loop_residual_px = 5.0;
  size_t weld_every = 3;
  double weld_share = 0.01;
  // Global bundle adjustment of an island: at once after two were fused or an owner closed a loop,
  // when so large a share of its keyframes, and at least so many, is new or was moved since the
  // last one, and at the end of all streams (docs/adr/0020-adjust-when-it-pays.md).
  double adjust_share = 0.2;
  size_t adjust_min_keyframes = 20;
  // At most, while streams run: robots want the cores, and an urgent fusing cancels it.
  int adjust_iterations = 20;
  // After all streams have ended: maps that drifted far want more.
  int last_adjust_iterations = 120;
  // Keyframes of whose points so large a share is seen by three others as well are culled from the
  // global layer after an adjustment (0: none), and the most redundant beyond so many of an island
  // (0: any number stays). Their owners keep them.
  double cull_share = 0;
  size_t cull_target = 0;
  // Local motion of a placed keyframe relative to its parent that calls for a refresh.
  double local_motion_px = 1.0;
  // Foreign keyframes that one agent is sent at most; the nearest ones.
  size_t max_shared_keyframes = 1000;
  // No threads: RunFusionUntilIdle does all, in a fixed order.
  bool deterministic = false;

  // What changes speed, and the limits.

  int adjust_threads = 1;
  // Missions whose requests of one lane (verifying and fusing; adjusting) are with a worker at the
  // same time: about as many as there are workers.
  int fusion_threads = 1;
  // Attempts at a request that a worker answers with an error. UNAVAILABLE does not count when
  // there are threads: it waits `retry_ms` and goes on.
  int max_attempts = 3;
  int retry_ms = 1000;
  size_t max_missions = 1000;
  size_t max_agents_per_mission = 1000;
  size_t max_local_maps_per_mission = 1000;
  size_t max_keypoints_per_keyframe = 20000;
  // Of what its camera saw: keypoints and descriptors.
  size_t max_keyframe_bytes = 2u << 20;
  size_t max_cameras_per_local_map = 16;
  // While a batch is applied, all other robots of the mission wait.
  size_t max_items_per_batch = 200000;
  // Beside its items: map_store/ingest/batch_cost.h.
  uint64_t max_pair_steps_per_batch = 1000000;
  // References of one local map to what has not arrived: how many wait, and how long.
  size_t max_parked_references = 100000;
  double max_parked_s = 3600;
  // Kept of what one agent, and all agents of a mission, sent.
  uint64_t max_bytes_per_agent = uint64_t{16} << 30;
  uint64_t max_bytes_per_mission = uint64_t{64} << 30;
  // Of the process, all together: beyond that nothing is taken in. 0: no limit.
  uint64_t memory_budget_bytes = 0;
  // Of a backup that is restored.
  uint64_t max_backup_bytes = uint64_t{64} << 30;
  size_t max_page_size = 10000;

  // INVALID_ARGUMENT naming the field.
  absl::Status Validate() const;

  // For what was accepted before, under other limits: a batch may hold anything that is possible.
  static MapStoreOptions WithoutBatchLimits();
};

}  // namespace corbslam

#endif  // CORBSLAM_MAP_STORE_OPTIONS_H_

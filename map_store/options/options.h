// The options of the map store.
#ifndef CORBSLAM_MAP_STORE_OPTIONS_OPTIONS_H_
#define CORBSLAM_MAP_STORE_OPTIONS_OPTIONS_H_

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"

namespace corbslam::map_store {

struct MapStoreOptions {
  // Options that change results.

  // How many of a local map's newest keyframes are provisional: they are not queried for overlaps
  // and not placed by fusion until this many newer ones have arrived, or the local map is closed.
  // The robot's local adjustment has then moved them as often (docs/adr/0003-settled-keyframes.md).
  size_t settle_after = 3;
  // Other agents hear of a keyframe when this many newer ones have arrived (0: at once), or the
  // local map is closed; and again when it moves.
  size_t share_after = 0;
  // A candidate must share at least this many words with the query, and at least this share of the
  // words that the best candidate shares with it.
  int min_shared_words = 10;
  double min_shared_words_ratio = 0.6;
  // Groups of covisible candidates that are verified per query and local map.
  size_t max_candidate_groups = 3;
  // Keyframes around the ends of a new overlap whose points a worker is sent for fusing.
  int neighbourhood = 10;
  // No further overlap is looked for within this many keyframes of one that has an accepted overlap
  // with the same local map.
  size_t overlap_spacing = 3;
  // Keyframes of one local map nearer than this in its order are no loop.
  size_t min_loop_gap = 30;
  // Query and candidate that share this many landmarks count as linked already, if these landmarks
  // agree with the graph to `loop_residual_px`.
  int min_shared_landmarks = 30;
  // An overlap within an island that agrees with the graph to `loop_residual_px` is not urgent.
  // Such overlaps are welded together when there are at least `weld_every`, and at least
  // `weld_share` of the island's keyframes in number, or at the end of all streams.
  double loop_residual_px = 5.0;
  size_t weld_every = 3;
  double weld_share = 0.01;
  // An island has a global bundle adjustment at once after two were fused or an owner closed a
  // loop, when at least `adjust_share` of its keyframes, and `adjust_min_keyframes` in number, are
  // new or were moved since the last one, and at the end of all streams
  // (docs/adr/0020-adjust-when-it-pays.md).
  double adjust_share = 0.2;
  size_t adjust_min_keyframes = 20;
  // Iterations of an adjustment at most while streams run: robots want the cores, and an urgent
  // fusing cancels the adjustment.
  int adjust_iterations = 20;
  // Iterations at most after all streams have ended: maps that drifted far need more.
  int last_adjust_iterations = 120;
  // After an adjustment, keyframes are culled from the global layer if at least this share of their
  // points is seen by three others as well (0: none are), and the most redundant ones beyond
  // `cull_target` of an island (0: any number stays). Their owners keep them.
  double cull_share = 0;
  size_t cull_target = 0;
  // Whether the store lets go of keyframes that others stand in for, and of points that have
  // vanished, of local maps that are closed and joined (docs/adr/0033-what-stays-of-a-session.md);
  // and the share of its landmarks that others see by which a keyframe goes.
  bool retire = false;
  double retire_share = 0.9;
  // Whether an agent's closed local maps that fusion has joined become one
  // (docs/adr/0036-sessions-become-one.md), but for the newest `keep_local_maps` of each agent.
  bool join_local_maps = false;
  size_t keep_local_maps = 8;
  // Local motion of a placed keyframe relative to its parent that calls for a refresh.
  double local_motion_px = 1.0;
  // Foreign keyframes that one agent is sent at most; it is sent the nearest ones.
  size_t max_shared_keyframes = 1000;
  // The store starts no threads: RunFusionUntilIdle does all the work, in a fixed order.
  bool deterministic = false;

  // Options that change speed, and the limits.

  int adjust_threads = 1;
  // Missions whose requests of one lane (verifying and fusing; adjusting) are with a worker at the
  // same time. It should be about the number of workers.
  int fusion_threads = 1;
  // Attempts at a request that a worker answers with an error. UNAVAILABLE does not count as one
  // when there are threads: the thread waits `retry_ms` and tries again.
  int max_attempts = 3;
  int retry_ms = 1000;
  // Missions in memory, and those that are asleep.
  size_t max_missions = 1000;
  size_t max_missions_asleep = 100000;
  // A mission that nobody has used for so many seconds leaves memory; 0: none ever does, unless
  // somebody asks for it. Without a journal none can.
  double sleep_after_s = 0;
  // A call that needs a mission which is asleep returns AsleepError (map_store/view/asleep_error.h)
  // at once, for who can come again when it is awake. False: the call waits.
  bool wake_in_background = false;
  // Seconds at an orderly end for snapshots of missions that would otherwise be read at the next
  // start.
  double end_s = 5;
  size_t max_agents_per_mission = 1000;
  size_t max_local_maps_per_mission = 1000;
  size_t max_keypoints_per_keyframe = 20000;
  // Bytes of what a keyframe's camera saw: keypoints and descriptors.
  size_t max_keyframe_bytes = 2u << 20;
  size_t max_cameras_per_local_map = 16;
  // While a batch is applied, all other robots of the mission wait. Frames, which cost little, are
  // counted by themselves.
  size_t max_items_per_batch = 65000;
  size_t max_frames_per_batch = 200000;
  // What applying a batch may cost beside its number of items: map_store/ingest/batch_cost.h.
  uint64_t max_pair_steps_per_batch = 500000;
  // How many references of one local map wait for what has not arrived, and how long.
  size_t max_parked_references = 65000;
  double max_parked_s = 3600;
  // Frames kept of an agent that only localises; beyond, each second one goes (LocalisedTrack).
  size_t max_localised_frames_per_agent = 200000;
  // Bytes kept of what one agent, and all agents of a mission, sent.
  uint64_t max_bytes_per_agent = uint64_t{16} << 30;
  uint64_t max_bytes_per_mission = uint64_t{64} << 30;
  // Bytes of keyframes' pictures that are kept of a mission; beyond, the oldest go. 0: none.
  uint64_t max_picture_bytes_per_mission = 256 << 20;
  // Bytes of memory of the whole process, beyond which nothing is taken in. 0: no limit.
  uint64_t memory_budget_bytes = 0;
  // Bytes of a backup that is restored.
  uint64_t max_backup_bytes = uint64_t{64} << 30;
  size_t max_page_size = 10000;

  // Returns INVALID_ARGUMENT, naming the field, if an option is out of its range.
  absl::Status Validate() const;

  // Returns options for what was accepted before under other limits: a batch may hold anything that
  // is possible.
  static MapStoreOptions WithoutBatchLimits();
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_OPTIONS_OPTIONS_H_

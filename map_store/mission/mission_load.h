// Says how much a mission holds and how much waits in it, as a dashboard and an autoscaler want to
// know every few seconds.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_LOAD_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_LOAD_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "map_store/fusion/fusion_policy.h"

namespace corbslam::map_store {

// Numbers of requests to fusion workers, by kind.
struct FusionRequestCounts {
  size_t verify = 0;
  size_t fuse = 0;
  size_t adjust = 0;
  friend bool operator==(const FusionRequestCounts&, const FusionRequestCounts&) = default;
};

struct MissionLoad {
  std::string mission;
  uint64_t revision = 0;
  // Number of agents that ever were in it, and of those with a session now.
  size_t agents = 0;
  size_t connected_agents = 0;
  size_t local_maps = 0;
  size_t joined_local_maps = 0;     // Those that have become parts of these.
  size_t forgotten_local_maps = 0;  // Those that somebody deleted.
  size_t islands = 0;
  size_t keyframes = 0;
  // Number of points of all local maps: a landmark counts as often as there are points of it.
  size_t map_points = 0;
  // What the store itself let go of (LocalMapState).
  uint64_t retired_keyframes = 0;
  uint64_t faded_points = 0;
  // About how much memory its map takes, and what it takes of the journal's disk.
  uint64_t memory_bytes = 0;
  uint64_t disk_bytes = 0;
  // The same numbers as in MissionStatistics.
  uint64_t overlaps_queried = 0;
  uint64_t overlaps_verified = 0;
  uint64_t overlaps_accepted = 0;
  uint64_t failed_requests = 0;
  // Requests that there would be if workers were idle, less those that a worker has; 0 without a
  // worker.
  FusionRequestCounts waiting;
  // Seconds for which the state's lock was held for writing, while all others wait, since the
  // process began: all together, and the longest time.
  double written_s = 0;
  double longest_write_s = 0;
};

// Counts all requests that the policy has for the summary, also those that run: each action that it
// decides is taken as done, and the next one asked for, until none is left.
FusionRequestCounts CountRequests(FusionSummary summary, const PolicyLimits& limits);

// Counts one of this kind less, if there is any.
void TakeOne(FusionAction::Kind kind, FusionRequestCounts& counts);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_LOAD_H_

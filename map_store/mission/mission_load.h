// How much a mission holds and how much waits in it: what a dashboard and an autoscaler want to
// know every few seconds.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_LOAD_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_LOAD_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "map_store/fusion/fusion_policy.h"

namespace corbslam {

// Requests to fusion workers, by kind.
struct FusionRequestCounts {
  size_t verify = 0;
  size_t fuse = 0;
  size_t adjust = 0;
  friend bool operator==(const FusionRequestCounts&, const FusionRequestCounts&) = default;
};

struct MissionLoad {
  std::string mission;
  uint64_t revision = 0;
  // Agents that ever were in it, and those with a session now.
  size_t agents = 0;
  size_t connected_agents = 0;
  size_t local_maps = 0;
  size_t islands = 0;
  size_t keyframes = 0;
  // Of all local maps: a landmark counts as often as there are points of it.
  size_t map_points = 0;
  // As in MissionStatistics.
  uint64_t overlaps_queried = 0;
  uint64_t overlaps_verified = 0;
  uint64_t overlaps_accepted = 0;
  uint64_t failed_requests = 0;
  // Requests that there would be if workers were idle and that none works on; none without a
  // worker.
  FusionRequestCounts waiting;
};

namespace map_store {

// All requests that the policy has for the summary, what runs included: each action that it decides
// is taken as done, and the next one asked for, until none is left.
FusionRequestCounts CountRequests(FusionSummary summary, const PolicyLimits& limits);

// One of this kind less, if there is any.
void TakeOne(FusionAction::Kind kind, FusionRequestCounts& counts);

}  // namespace map_store
}  // namespace corbslam

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_LOAD_H_

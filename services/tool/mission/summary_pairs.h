// Counts overlaps of a mission for every two of its local maps.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_SUMMARY_PAIRS_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_SUMMARY_PAIRS_H_

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "services/tool/mission/mission_summary.h"

namespace corbslam::services {

struct PairOverlaps {
  bool same_island = false;
  uint32_t most_inliers = 0;  // Of an accepted overlap.
  std::map<v1::OverlapVerdict, int> verdicts;
  int accepted = 0;
  int refused = 0;
  // Number of keyframes of one that were not looked up in the other: those that wait for a fusion
  // worker, and those that were given up because workers failed.
  uint64_t waiting = 0;
  uint64_t failed = 0;
  // True if one of the two has no settled keyframe: there is nothing to compare yet.
  bool is_too_early = false;
};

// Returns the pairs by the short names of their local maps (ShortNames), the earlier one first: all
// pairs of different robots, whether anything was compared or not, and the pairs of one robot that
// were compared.
std::map<std::pair<std::string, std::string>, PairOverlaps> CountPairs(
    const MissionSummary& summary);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_SUMMARY_PAIRS_H_

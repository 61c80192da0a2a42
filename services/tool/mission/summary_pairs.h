// Overlaps of a mission, counted for every two of its local maps.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_SUMMARY_PAIRS_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_SUMMARY_PAIRS_H_

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "services/tool/mission/mission_summary.h"

namespace corbslam {

// "alpha/1", the first local map of alpha, by the name of the resource.
std::map<std::string, std::string> ShortNames(const MissionSummary& summary);

struct PairOverlaps {
  bool same_island = false;
  uint32_t most_inliers = 0;  // Of an accepted one.
  std::map<v1::OverlapVerdict, int> verdicts;
  int accepted = 0;
  int refused = 0;
  // Keyframes of one that were not looked up in the other: those that wait for a fusion worker, and
  // those that were given up because workers failed.
  uint64_t waiting = 0;
  uint64_t failed = 0;
  // One of the two has no settled keyframe: there is nothing to compare yet.
  bool is_too_early = false;
};

// By the short names of two local maps, the one that came first first: those of different robots,
// whether anything was compared or not, and all others that were.
std::map<std::pair<std::string, std::string>, PairOverlaps> CountPairs(
    const MissionSummary& summary);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_SUMMARY_PAIRS_H_

// Overlaps of a mission, counted for every two of its local maps.
#ifndef CORBSLAM_SERVICES_CORBSLAM_SUMMARY_PAIRS_H_
#define CORBSLAM_SERVICES_CORBSLAM_SUMMARY_PAIRS_H_

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "services/corbslam/mission_summary.h"

namespace corbslam {

// "alpha/1", the first local map of alpha, by the name of the resource.
std::map<std::string, std::string> ShortNames(const MissionSummary& summary);

struct PairOverlaps {
  bool same_island = false;
  uint32_t most_inliers = 0;  // Of an accepted one.
  std::map<v1::OverlapVerdict, int> verdicts;
  int accepted = 0;
  int refused = 0;
};

// By the short names of two local maps, the one that came first first: those of different robots,
// whether anything was compared or not, and all others that were.
std::map<std::pair<std::string, std::string>, PairOverlaps> CountPairs(
    const MissionSummary& summary);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_CORBSLAM_SUMMARY_PAIRS_H_

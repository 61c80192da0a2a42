#include "services/corbslam/summary_pairs.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

// missions/M/localMaps/L of missions/M/localMaps/L/keyframes/K.
std::string LocalMapOf(const std::string& keyframe) {
  return keyframe.substr(0, keyframe.find("/keyframes/"));
}

}  // namespace

std::map<std::string, std::string> ShortNames(const MissionSummary& summary) {
  std::map<std::string, std::string> names;
  std::map<std::string, int> counts;
  for (const v1::LocalMap& local_map : summary.local_maps) {
    const std::string robot = LastSegment(local_map.agent());
    names[local_map.name()] = absl::StrCat(robot, "/", ++counts[robot]);
  }
  return names;
}

std::map<std::pair<std::string, std::string>, PairOverlaps> CountPairs(
    const MissionSummary& summary) {
  const std::map<std::string, std::string> names = ShortNames(summary);
  std::map<std::string, size_t> order;
  std::map<std::string, std::string> islands;
  std::map<std::pair<std::string, std::string>, PairOverlaps> pairs;
  for (const v1::LocalMap& second : summary.local_maps) {
    for (const v1::LocalMap& first : summary.local_maps) {
      if (first.name() == second.name()) break;
      if (first.agent() == second.agent()) continue;
      pairs[{names.at(first.name()), names.at(second.name())}].same_island =
          first.island() == second.island();
    }
    order.emplace(second.name(), order.size());
    islands[second.name()] = second.island();
  }
  for (const v1::Overlap& overlap : summary.overlaps) {
    std::string first = LocalMapOf(overlap.query());
    std::string second = LocalMapOf(overlap.candidate());
    // One that came after the local maps were listed.
    if (!order.contains(first) || !order.contains(second)) continue;
    if (order.at(first) > order.at(second)) std::swap(first, second);
    PairOverlaps& pair = pairs[{names.at(first), names.at(second)}];
    pair.same_island = islands.at(first) == islands.at(second);
    ++pair.verdicts[overlap.verdict()];
    const bool accepted = overlap.verdict() == v1::OVERLAP_VERDICT_ACCEPTED;
    ++(accepted ? pair.accepted : pair.refused);
    if (accepted) pair.most_inliers = std::max(pair.most_inliers, overlap.inliers());
  }
  return pairs;
}

}  // namespace corbslam

#include "services/tool/mission/summary_pairs.h"

#include <algorithm>
#include <utility>

#include "services/client/store/local_map_names.h"

namespace corbslam::services {
namespace {

// Returns missions/M/localMaps/L for missions/M/localMaps/L/keyframes/K.
std::string LocalMapOf(const std::string& keyframe) {
  return keyframe.substr(0, keyframe.find("/keyframes/"));
}

using Pairs = std::map<std::pair<std::string, std::string>, PairOverlaps>;

// Finds the pair of two local maps by the names of their resources. Returns null if one came after
// the local maps were listed.
class PairFinder {
 public:
  PairFinder(const MissionSummary& summary, Pairs& pairs) : pairs_(pairs) {
    const LocalMapNames names = ShortNames(summary.local_maps);
    for (const v1::LocalMap& local_map : summary.local_maps) {
      const Whole whole = {wholes_.size(), names.at(local_map.name())};
      wholes_.emplace(local_map.name(), whole);
      for (const std::string& part : local_map.joined_local_maps()) wholes_.emplace(part, whole);
    }
  }

  PairOverlaps* Find(std::string first, std::string second) {
    if (!wholes_.contains(first) || !wholes_.contains(second)) return nullptr;
    if (wholes_.at(first).place > wholes_.at(second).place) std::swap(first, second);
    return &pairs_[{wholes_.at(first).name, wholes_.at(second).name}];
  }

 private:
  // A local map that is listed: where in the list, and what it is called.
  struct Whole {
    size_t place = 0;
    std::string name;
  };

  std::map<std::string, Whole> wholes_;  // By its resource's name, and by those of its parts.
  Pairs& pairs_;
};

// Adds the look-ups that wait or failed to the pairs that are listed.
void AddUncompared(const MissionSummary& summary, Pairs& pairs) {
  Pairs all = pairs;
  PairFinder finder(summary, all);
  for (const v1::UncomparedPair& uncompared : summary.statistics.uncompared()) {
    PairOverlaps* pair = finder.Find(uncompared.query(), uncompared.against());
    if (pair == nullptr) continue;
    pair->waiting += uncompared.waiting();
    pair->failed += uncompared.failed();
  }
  for (auto& [names, pair] : pairs) pair = all.at(names);
}

void AddVerdict(const v1::Overlap& overlap, PairOverlaps& pair) {
  ++pair.verdicts[overlap.verdict()];
  const bool accepted = overlap.verdict() == v1::OVERLAP_VERDICT_ACCEPTED;
  ++(accepted ? pair.accepted : pair.refused);
  if (accepted) pair.most_inliers = std::max(pair.most_inliers, overlap.inliers());
}

}  // namespace

Pairs CountPairs(const MissionSummary& summary) {
  Pairs pairs;
  PairFinder finder(summary, pairs);
  std::map<std::string, std::string> islands;
  for (const v1::LocalMap& second : summary.local_maps) {
    for (const v1::LocalMap& first : summary.local_maps) {
      if (first.name() == second.name()) break;
      if (first.agent() == second.agent()) continue;
      PairOverlaps& pair = *finder.Find(first.name(), second.name());
      pair.same_island = first.island() == second.island();
      pair.is_too_early = std::min(first.settled_keyframes(), second.settled_keyframes()) == 0;
    }
    islands[second.name()] = second.island();
    for (const std::string& part : second.joined_local_maps()) islands[part] = second.island();
  }
  for (const v1::Overlap& overlap : summary.overlaps) {
    const std::string first = LocalMapOf(overlap.query());
    const std::string second = LocalMapOf(overlap.candidate());
    PairOverlaps* pair = finder.Find(first, second);
    if (pair == nullptr) continue;
    pair->same_island = islands.at(first) == islands.at(second);
    AddVerdict(overlap, *pair);
  }
  AddUncompared(summary, pairs);
  return pairs;
}

}  // namespace corbslam::services

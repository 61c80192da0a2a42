#include "slam/place/candidate_groups.h"

#include <algorithm>
#include <set>

#include "absl/container/flat_hash_map.h"

namespace corbslam {
namespace {

// How many of a candidate's neighbours may support it.
constexpr int kNeighbours = 10;

bool IsBetter(const PlaceCandidate& a, const PlaceCandidate& b) {
  return a.score != b.score ? a.score > b.score : a.id < b.id;
}

using Candidates = absl::flat_hash_map<KeyframeId, PlaceCandidate>;

CandidateGroup GroupAround(const Map& map, const PlaceCandidate& centre,
                           const Candidates& candidates) {
  std::vector<PlaceCandidate> members = {centre};
  for (const CovisibleKeyframe& neighbour : map.BestCovisible(centre.id, kNeighbours)) {
    const auto found = candidates.find(neighbour.id);
    if (found != candidates.end()) members.push_back(found->second);
  }
  std::sort(members.begin(), members.end(), IsBetter);
  CandidateGroup group;
  group.best = members.front();
  for (const PlaceCandidate& member : members) {
    group.score += member.score;
    group.members.push_back(member.id);
  }
  return group;
}

}  // namespace

std::vector<CandidateGroup> GroupByCovisibility(const Map& map,
                                                const std::vector<PlaceCandidate>& candidates,
                                                size_t max_groups, double min_score_of_best) {
  Candidates by_id;
  for (const PlaceCandidate& candidate : candidates) by_id.emplace(candidate.id, candidate);
  std::vector<CandidateGroup> groups;
  groups.reserve(candidates.size());
  for (const PlaceCandidate& candidate : candidates) {
    groups.push_back(GroupAround(map, candidate, by_id));
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const CandidateGroup& a, const CandidateGroup& b) {
                     return a.score != b.score ? a.score > b.score : a.best.id < b.best.id;
                   });

  std::vector<CandidateGroup> kept;
  std::set<KeyframeId> seen;
  for (CandidateGroup& group : groups) {
    if (kept.size() == max_groups || group.score < min_score_of_best * groups.front().score) break;
    if (seen.insert(group.best.id).second) kept.push_back(group);
  }
  return kept;
}

}  // namespace corbslam

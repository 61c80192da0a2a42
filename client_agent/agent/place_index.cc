#include "client_agent/agent/place_index.h"

#include <algorithm>
#include <utility>

#include "slam/place/candidate_groups.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMaxGroups = 5;

}  // namespace

void PlaceIndex::Add(KeyframeId id, std::shared_ptr<const Words> words) {
  absl::MutexLock lock(&mutex_);
  database_.Add(id, std::move(words));
}

void PlaceIndex::Remove(KeyframeId id) {
  absl::MutexLock lock(&mutex_);
  database_.Remove(id);
}

std::vector<KeyframeId> PlaceIndex::BestOfGroups(
    const std::vector<PlaceCandidate>& candidates) const {
  std::vector<KeyframeId> best;
  map_.Read([&](const Map& map) {
    for (const CandidateGroup& group : GroupByCovisibility(map, candidates, kMaxGroups)) {
      best.push_back(group.best.id);
    }
  });
  return best;
}

std::vector<KeyframeId> PlaceIndex::Find(const Words& words) const {
  std::vector<PlaceCandidate> candidates;
  {
    absl::MutexLock lock(&mutex_);
    candidates = database_.Query(words.bag);
  }
  return BestOfGroups(candidates);
}

double PlaceIndex::LeastNeighbourScore(const Keyframe& query) const {
  return map_.Read([&](const Map& map) {
    double least = 1;
    for (const CovisibleKeyframe& neighbour : map.Covisible(query.id())) {
      const Keyframe& keyframe = *map.FindKeyframe(neighbour.id);
      if (keyframe.words == nullptr) continue;
      least = std::min(least, Similarity(query.words->bag, keyframe.words->bag));
    }
    return least < 1 ? least : 0;
  });
}

std::vector<KeyframeId> PlaceIndex::FindLoops(const Keyframe& query,
                                              const absl::btree_set<KeyframeId>& excluded) const {
  QueryOptions options;
  options.min_score = LeastNeighbourScore(query);
  options.admit = [&](KeyframeId id) { return !excluded.contains(id); };
  std::vector<PlaceCandidate> candidates;
  {
    absl::MutexLock lock(&mutex_);
    candidates = database_.Query(query.words->bag, options);
  }
  return BestOfGroups(candidates);
}

}  // namespace corbslam::client_agent

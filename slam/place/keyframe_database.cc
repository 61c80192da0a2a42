#include "slam/place/keyframe_database.h"

#include <algorithm>
#include <utility>

namespace corbslam {
namespace {

struct Shared {
  int words = 0;
  double score = 0;
};

bool IsBetter(const PlaceCandidate& a, const PlaceCandidate& b) {
  return a.score != b.score ? a.score > b.score : a.id < b.id;
}

int MostSharedWords(const std::vector<PlaceCandidate>& candidates) {
  int most = 0;
  for (const PlaceCandidate& candidate : candidates) most = std::max(most, candidate.shared_words);
  return most;
}

}  // namespace

void KeyframeDatabase::Add(KeyframeId id, std::shared_ptr<const Words> words) {
  Remove(id);
  uint32_t slot = static_cast<uint32_t>(entries_.size());
  if (free_slots_.empty()) {
    entries_.emplace_back();
  } else {
    slot = free_slots_.back();
    free_slots_.pop_back();
  }
  slots_[id] = slot;
  if (words) {
    for (const WordWeight& word : words->bag) postings_[word.word].push_back({slot, word.weight});
  }
  entries_[slot] = {id, std::move(words)};
}

bool KeyframeDatabase::Remove(KeyframeId id) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return false;
  const uint32_t slot = found->second;
  slots_.erase(found);
  const Entry entry = std::exchange(entries_[slot], Entry());
  free_slots_.push_back(slot);
  if (!entry.words) return true;
  for (const WordWeight& word : entry.words->bag) {
    const auto postings = postings_.find(word.word);
    std::erase_if(postings->second, [slot](const Posting& p) { return p.slot == slot; });
    if (postings->second.empty()) postings_.erase(postings);
  }
  return true;
}

std::vector<PlaceCandidate> KeyframeDatabase::Query(const BagOfWords& query,
                                                    const QueryOptions& options) const {
  std::vector<Shared> shared(entries_.size());
  std::vector<uint32_t> touched;
  for (const WordWeight& word : query) {
    const auto postings = postings_.find(word.word);
    if (postings == postings_.end()) continue;
    for (const Posting& posting : postings->second) {
      Shared& with = shared[posting.slot];
      if (with.words++ == 0) touched.push_back(posting.slot);
      with.score += static_cast<double>(std::min(word.weight, posting.weight));
    }
  }

  std::vector<PlaceCandidate> candidates;
  candidates.reserve(touched.size());
  for (const uint32_t slot : touched) {
    const KeyframeId id = entries_[slot].id;
    if (options.admit && !options.admit(id)) continue;
    candidates.push_back({id, shared[slot].words, shared[slot].score});
  }
  const double least_words = std::max(
      static_cast<double>(options.min_shared_words),
      options.min_shared_fraction_of_best * static_cast<double>(MostSharedWords(candidates)));
  std::erase_if(candidates, [&](const PlaceCandidate& candidate) {
    return candidate.shared_words < least_words || candidate.score < options.min_score;
  });
  std::sort(candidates.begin(), candidates.end(), IsBetter);
  if (candidates.size() > options.max_results) candidates.resize(options.max_results);
  return candidates;
}

}  // namespace corbslam

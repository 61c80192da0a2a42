#include "slam/place/keyframe_database.h"

#include <algorithm>
#include <utility>

#include "slam/util/heap_bytes.h"

namespace corbslam {
namespace {

// An array for all slots is no dearer than a hash table for the touched ones up to so many slots a
// posting.
constexpr size_t kMaxSlotsPerPosting = 4;

bool IsBetter(const PlaceCandidate& a, const PlaceCandidate& b) {
  return a.score != b.score ? a.score > b.score : a.id < b.id;
}

int MostSharedWords(const std::vector<PlaceCandidate>& candidates) {
  int most = 0;
  for (const PlaceCandidate& candidate : candidates) most = std::max(most, candidate.shared_words);
  return most;
}

}  // namespace

uint32_t KeyframeDatabase::TakeSlot() {
  if (free_slots_.empty()) {
    entries_.emplace_back();
    return static_cast<uint32_t>(entries_.size() - 1);
  }
  const uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  return slot;
}

uint64_t KeyframeDatabase::OuterPlaces(const Postings& postings) {
  return postings.capacity() > Postings().capacity() ? postings.capacity() : 0;
}

uint32_t KeyframeDatabase::AddPosting(uint32_t word, const Posting& posting) {
  Postings& postings = postings_[word];
  outer_places_ -= OuterPlaces(postings);
  postings.push_back(posting);
  outer_places_ += OuterPlaces(postings);
  ++posting_count_;
  return static_cast<uint32_t>(postings.size() - 1);
}

void KeyframeDatabase::Add(KeyframeId id, std::shared_ptr<const Words> words) {
  Remove(id);
  const uint32_t slot = TakeSlot();
  slots_[id] = slot;
  Entry entry;
  entry.id = id;
  entry.words = std::move(words);
  if (entry.words) {
    entry.positions.reserve(entry.words->bag.size());
    for (const WordWeight& word : entry.words->bag) {
      entry.positions.push_back(AddPosting(word.word, {slot, word.weight}));
    }
  }
  entries_[slot] = std::move(entry);
}

void KeyframeDatabase::RemovePosting(uint32_t word, uint32_t position) {
  const auto found = postings_.find(word);
  Postings& postings = found->second;
  if (position + 1 < postings.size()) {
    const Posting moved = postings[position] = postings.back();
    Entry& owner = entries_[moved.slot];
    const BagOfWords& bag = owner.words->bag;
    const auto of_word = std::lower_bound(
        bag.begin(), bag.end(), word,
        [](const WordWeight& weight, uint32_t wanted) { return weight.word < wanted; });
    owner.positions[static_cast<size_t>(of_word - bag.begin())] = position;
  }
  postings.pop_back();
  --posting_count_;
  if (!postings.empty()) return;
  outer_places_ -= OuterPlaces(postings);
  postings_.erase(found);
}

uint64_t KeyframeDatabase::HeapBytes() const {
  return HashTableBytes<std::pair<const KeyframeId, uint32_t>>(slots_.size()) +
         VectorBytes(entries_) + VectorBytes(free_slots_) + entries_.size() * HeapBlockBytes(1) +
         posting_count_ * sizeof(uint32_t) +
         HashTableBytes<std::pair<const uint32_t, Postings>>(postings_.size()) +
         outer_places_ * sizeof(Posting);
}

bool KeyframeDatabase::Remove(KeyframeId id) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return false;
  const uint32_t slot = found->second;
  slots_.erase(found);
  const Entry entry = std::exchange(entries_[slot], Entry());
  for (size_t i = 0; i < entry.positions.size(); ++i) {
    RemovePosting(entry.words->bag[i].word, entry.positions[i]);
  }
  free_slots_.push_back(slot);
  return true;
}

std::vector<KeyframeDatabase::QueryWord> KeyframeDatabase::FindWords(
    const BagOfWords& query) const {
  std::vector<QueryWord> words;
  words.reserve(query.size());
  for (const WordWeight& word : query) {
    const auto postings = postings_.find(word.word);
    if (postings != postings_.end()) words.push_back({word.weight, &postings->second});
  }
  return words;
}

size_t KeyframeDatabase::Count(const std::vector<QueryWord>& words) {
  size_t count = 0;
  for (const QueryWord& word : words) count += word.postings->size();
  return count;
}

template <typename SharedBySlot>
std::vector<KeyframeDatabase::Shared> KeyframeDatabase::AddUp(const std::vector<QueryWord>& words,
                                                              SharedBySlot& by_slot) {
  std::vector<uint32_t> touched;
  for (const QueryWord& word : words) {
    for (const Posting& posting : *word.postings) {
      Shared& with = by_slot[posting.slot];
      if (with.words++ == 0) touched.push_back(posting.slot);
      with.score += static_cast<double>(std::min(word.weight, posting.weight));
    }
  }
  std::vector<Shared> shared;
  shared.reserve(touched.size());
  for (const uint32_t slot : touched) {
    shared.push_back(by_slot[slot]);
    shared.back().slot = slot;
  }
  return shared;
}

std::vector<KeyframeDatabase::Shared> KeyframeDatabase::FindSharing(const BagOfWords& query) const {
  const std::vector<QueryWord> words = FindWords(query);
  if (entries_.size() <= kMaxSlotsPerPosting * Count(words)) {
    std::vector<Shared> by_slot(entries_.size());
    return AddUp(words, by_slot);
  }
  absl::flat_hash_map<uint32_t, Shared> by_slot;
  return AddUp(words, by_slot);
}

std::vector<PlaceCandidate> KeyframeDatabase::Query(const BagOfWords& query,
                                                    const QueryOptions& options) const {
  const std::vector<Shared> sharing = FindSharing(query);
  std::vector<PlaceCandidate> candidates;
  candidates.reserve(sharing.size());
  for (const Shared& with : sharing) {
    // Most keyframes share a word or two: nobody asks whether they are admitted.
    if (with.words < options.min_shared_words) continue;
    const KeyframeId id = entries_[with.slot].id;
    if (options.admit && !options.admit(id)) continue;
    candidates.push_back({id, with.words, with.score});
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

// Finds the keyframes that look like a picture, by an inverted index from words to keyframes.
#ifndef CORBSLAM_SLAM_PLACE_KEYFRAME_DATABASE_H_
#define CORBSLAM_SLAM_PLACE_KEYFRAME_DATABASE_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "slam/util/ids.h"
#include "slam/vocabulary/words.h"

namespace corbslam {

struct PlaceCandidate {
  KeyframeId id;
  int shared_words = 0;
  double score = 0;  // Similarity of the bags, 0 to 1.
};

struct QueryOptions {
  int min_shared_words = 1;
  // Share of the most words that any admitted keyframe shares (Mur-Artal and Tardos, ICRA 2014).
  double min_shared_fraction_of_best = 0.8;
  double min_score = 0;
  size_t max_results = std::numeric_limits<size_t>::max();
  // Keyframes for which it is false are as if they were not there; null admits all.
  std::function<bool(KeyframeId)> admit;
};

// The database of one local map. Not thread-safe: its owner locks; queries may run side by side.
// Adding and removing cost as much as the keyframe has words, whatever the map's size.
class KeyframeDatabase {
 public:
  // Replaces the words of a keyframe that is there already. Null words are an empty bag.
  void Add(KeyframeId id, std::shared_ptr<const Words> words);
  // Returns false if it is not there.
  bool Remove(KeyframeId id);
  bool Contains(KeyframeId id) const { return slots_.contains(id); }
  size_t size() const { return slots_.size(); }
  // Returns about how much of the heap it takes, without the words, which others have, too.
  uint64_t HeapBytes() const;

  // Returns the best first, ties by id. A query costs as much as the postings that it touches,
  // whatever the map's size.
  std::vector<PlaceCandidate> Query(const BagOfWords& query,
                                    const QueryOptions& options = {}) const;
  // Returns the number of these postings: for each word of the query, the keyframes that have it.
  size_t CountPostings(const BagOfWords& query) const { return Count(FindWords(query)); }

 private:
  struct Posting {
    uint32_t slot = 0;
    float weight = 0;
  };
  // Most words are known to one keyframe or two: their postings lie in the table itself.
  using Postings = absl::InlinedVector<Posting, 2>;
  struct Entry {
    KeyframeId id;
    std::shared_ptr<const Words> words;
    // Position of each word's posting in its list.
    std::vector<uint32_t> positions;
  };
  // What a keyframe has in common with a query.
  struct Shared {
    uint32_t slot = 0;
    int words = 0;
    double score = 0;
  };
  struct QueryWord {
    float weight = 0;
    const Postings* postings = nullptr;
  };

  uint32_t TakeSlot();
  static uint64_t OuterPlaces(const Postings& postings);
  // Returns its position.
  uint32_t AddPosting(uint32_t word, const Posting& posting);
  // The last posting of the word takes the place of the removed one.
  void RemovePosting(uint32_t word, uint32_t position);
  // Finds those of the query's words that any keyframe has.
  std::vector<QueryWord> FindWords(const BagOfWords& query) const;
  static size_t Count(const std::vector<QueryWord>& words);
  // `by_slot` is a vector or a hash table, empty.
  template <typename SharedBySlot>
  static std::vector<Shared> AddUp(const std::vector<QueryWord>& words, SharedBySlot& by_slot);
  std::vector<Shared> FindSharing(const BagOfWords& query) const;

  absl::flat_hash_map<KeyframeId, uint32_t> slots_;
  std::vector<Entry> entries_;
  std::vector<uint32_t> free_slots_;
  absl::flat_hash_map<uint32_t, Postings> postings_;
  uint64_t posting_count_ = 0;
  // Places for postings outside of the table.
  uint64_t outer_places_ = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_PLACE_KEYFRAME_DATABASE_H_

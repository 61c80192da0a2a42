// Counts the pictures that are kept of a mission's keyframes, and says which go when there are too
// many.
#ifndef CORBSLAM_MAP_STORE_RECORDS_PICTURE_BOOK_H_
#define CORBSLAM_MAP_STORE_RECORDS_PICTURE_BOOK_H_

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// A picture that is kept somewhere else.
struct BookedPicture {
  uint64_t order = 0;  // Grows with each that comes.
  KeyframeId keyframe;
  uint64_t bytes = 0;
  uint64_t position = 0;  // Of the journal when it came.
};

// A value; not thread-safe.
class PictureBook {
 public:
  bool Has(KeyframeId keyframe) const { return orders_.contains(keyframe); }
  uint64_t bytes() const { return bytes_; }

  // Adds the newest picture, of a keyframe that has none, and returns it.
  BookedPicture Add(KeyframeId keyframe, uint64_t bytes, uint64_t position);
  // Adds one whose order is known.
  void Put(const BookedPicture& picture);
  // Takes the picture out, if there is one.
  std::optional<BookedPicture> Take(KeyframeId keyframe);
  // Takes out the oldest pictures until at most so many bytes are left.
  std::vector<BookedPicture> TakeBeyond(uint64_t max_bytes);
  // Returns the pictures that came up to the position and whose keyframes are not among the needed.
  std::vector<BookedPicture> FindUnneeded(uint64_t position,
                                          const absl::flat_hash_set<KeyframeId>& needed) const;

 private:
  std::map<uint64_t, BookedPicture> pictures_;  // By order.
  absl::flat_hash_map<KeyframeId, uint64_t> orders_;
  uint64_t bytes_ = 0;
  uint64_t last_order_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_PICTURE_BOOK_H_

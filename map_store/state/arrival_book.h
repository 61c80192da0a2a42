// The order in which a mission's local maps arrived, whatever has become of them since.
#ifndef CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_
#define CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_

#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Numbers the names of local maps as they arrive. One that became a part of another keeps its
// number, and that of a deleted one is not given again, so that a list goes on behind it. Is a
// value; written with the state, whose own order has gaps closed.
class ArrivalBook {
 public:
  ArrivalBook() = default;
  // Begins for a state from which so many names were gone by then: deleted, or parts of others.
  explicit ArrivalBook(uint64_t gone) : gone_(gone) {}
  // As it was when it was written.
  ArrivalBook(uint64_t gone, std::map<uint64_t, LocalMapId> names)
      : gone_(gone),
        next_(names.empty() ? 0 : std::prev(names.end())->first + 1),
        names_(std::move(names)) {
    for (const auto& [number, name] : names_) numbers_[name] = number;
  }

  void Add(LocalMapId name) {
    numbers_[name] = next_;
    names_.emplace(next_++, name);
  }

  // Tells books apart: one that was begun after more names had gone (for a state of an older
  // format) has other numbers.
  uint64_t gone() const { return gone_; }
  // The names by their numbers, those that are gone since included.
  const std::map<uint64_t, LocalMapId>& names() const { return names_; }
  // Returns the number of a name; 0 if it never arrived.
  uint64_t NumberOf(LocalMapId name) const {
    const auto it = numbers_.find(name);
    return it == numbers_.end() ? 0 : it->second;
  }

 private:
  uint64_t gone_ = 0;
  uint64_t next_ = 0;
  std::map<uint64_t, LocalMapId> names_;
  absl::flat_hash_map<LocalMapId, uint64_t> numbers_;  // Derived from `names_`.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_

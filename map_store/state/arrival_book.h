// The order in which a mission's local maps arrived, whatever has become of them since.
#ifndef CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_
#define CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_

#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

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
        names_(std::move(names)) {}

  void Add(LocalMapId name) { names_.emplace(next_++, name); }

  // Tells books apart: one that was begun after more names had gone (for a state of an older
  // format) has other numbers.
  uint64_t gone() const { return gone_; }
  // The names by their numbers, those that are gone since included.
  const std::map<uint64_t, LocalMapId>& names() const { return names_; }

 private:
  uint64_t gone_ = 0;
  uint64_t next_ = 0;
  std::map<uint64_t, LocalMapId> names_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_ARRIVAL_BOOK_H_

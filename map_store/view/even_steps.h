// Chooses about evenly among numbers that are passed one after the other.
#ifndef CORBSLAM_MAP_STORE_VIEW_EVEN_STEPS_H_
#define CORBSLAM_MAP_STORE_VIEW_EVEN_STEPS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace corbslam::map_store {

// Chooses at most `most` of the numbers from `first` to `last`: `first` if there is room for one,
// both if there is for two. A value; not thread-safe.
class EvenSteps {
 public:
  EvenSteps(uint64_t first, uint64_t last, size_t most)
      : first_(first), steps_(last - std::min(first, last)), most_(most) {}

  // Returns whether the next chosen number, or one behind it, has been reached; those that were
  // passed are chosen no more.
  bool Reach(uint64_t number) {
    bool is_reached = false;
    for (; next_ < most_ && Chosen(next_) <= number; ++next_) is_reached = true;
    return is_reached;
  }

 private:
  // Returns the `index`th; behind the last, numbers that do not come.
  uint64_t Chosen(size_t index) const {
    const uint64_t gaps = most_ - 1;
    return first_ + (gaps == 0 || steps_ <= gaps ? index : index * steps_ / gaps);
  }

  const uint64_t first_;
  const uint64_t steps_;
  const size_t most_;
  size_t next_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_EVEN_STEPS_H_

// Measures how much memory the process has, and gives back what it does not use.
#ifndef CORBSLAM_SLAM_UTIL_RESIDENT_MEMORY_H_
#define CORBSLAM_SLAM_UTIL_RESIDENT_MEMORY_H_

#include <cstdint>

namespace corbslam {

// Returns what the kernel counts as resident; 0 where it does not say.
uint64_t ResidentBytes();

// Returns how much of that is used, about: without what the allocator keeps of what was freed,
// which it has again at once. It looks at all of the heap, which takes a while.
uint64_t UsedBytes();

// Returns how much of the process's own memory is freed and kept by the allocator, about; what it
// has given back does not count. It looks at all of the heap.
uint64_t FreeHeapBytes();

// Gives memory that the process has freed back to the system, if it is much: the allocator would
// keep it, for ever where something small lies above it.
void ReturnFreeMemory();
// Returns it if it is more than `least_bytes`, for a thread that nobody waits for.
void ReturnFreeMemoryAbove(uint64_t least_bytes);

// Gives back what the allocator keeps whenever that has grown by `least_bytes`: what is left each
// time lies in pages of something that is used, and can't be had. One thread uses it at a time.
class HeapTrimmer {
 public:
  explicit HeapTrimmer(uint64_t least_bytes) : least_bytes_(least_bytes) {}

  // Returns whether it was worth while.
  bool GiveBack();

 private:
  const uint64_t least_bytes_;
  uint64_t left_bytes_ = 0;
};

// Returns free memory at the end of its scope, when what is declared after it is gone.
class ReturnsFreeMemory {
 public:
  ReturnsFreeMemory() = default;
  ~ReturnsFreeMemory() { ReturnFreeMemory(); }
  ReturnsFreeMemory(const ReturnsFreeMemory&) = delete;
  ReturnsFreeMemory& operator=(const ReturnsFreeMemory&) = delete;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_RESIDENT_MEMORY_H_

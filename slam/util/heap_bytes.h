// Says how much of the heap containers take, by what they have to allocate: glibc's allocator and
// the containers' own growth are counted in, what their elements have elsewhere is not. Bytes.
#ifndef CORBSLAM_SLAM_UTIL_HEAP_BYTES_H_
#define CORBSLAM_SLAM_UTIL_HEAP_BYTES_H_

#include <algorithm>
#include <cstdint>
#include <vector>

namespace corbslam {

// Returns what an allocation of so many bytes takes; none: nothing.
constexpr uint64_t HeapBlockBytes(uint64_t bytes) {
  constexpr uint64_t kHeader = 8;
  constexpr uint64_t kAlignment = 16;
  constexpr uint64_t kLeast = 32;
  if (bytes == 0) return 0;
  return std::max(kLeast, (bytes + kHeader + kAlignment - 1) / kAlignment * kAlignment);
}

template <typename T>
uint64_t VectorBytes(const std::vector<T>& vector) {
  return HeapBlockBytes(vector.capacity() * sizeof(T));
}

// Returns what std::map, std::set and their like take of so many entries.
template <typename Entry>
constexpr uint64_t TreeBytes(uint64_t entries) {
  constexpr uint64_t kLinks = 32;
  return entries * HeapBlockBytes(kLinks + sizeof(Entry));
}

// How many places absl's flat hash tables look at at once: what SSE2 holds, eight on other
// machines.
#ifdef __SSE2__
inline constexpr uint64_t kHashGroupPlaces = 16;
#else
inline constexpr uint64_t kHashGroupPlaces = 8;
#endif

// Returns what absl's flat hash tables take of so many entries that came one after the other: their
// places are one less than a power of two, an eighth of them stays empty (one of seven, where a
// group is eight), and each has a byte.
template <typename Entry>
constexpr uint64_t HashTableBytes(uint64_t entries) {
  if (entries == 0) return 0;
  const auto stay_empty = [](uint64_t places) {
    return places + 1 == kHashGroupPlaces ? 1 : places / 8;
  };
  uint64_t places = 1;
  while (entries > places - stay_empty(places)) places = 2 * places + 1;
  return HeapBlockBytes(places * (sizeof(Entry) + 1) + kHashGroupPlaces);
}

// Returns what one of absl's btrees takes of so many entries. One that is small grows as it needs
// to; the nodes of others are about four fifths full.
template <typename Entry>
constexpr uint64_t BtreeBytes(uint64_t entries) {
  constexpr uint64_t kNode = 256;
  constexpr uint64_t kHeader = 16;
  constexpr uint64_t kLeastPlaces = 3;
  constexpr uint64_t kPlaces = std::max<uint64_t>((kNode - kHeader) / sizeof(Entry), kLeastPlaces);
  if (entries > kPlaces) {
    const uint64_t leaves = entries * 5 / 4 / kPlaces + 1;
    const uint64_t inner = leaves / (kPlaces + 1) + 1;
    return leaves * HeapBlockBytes(kNode) +
           inner * HeapBlockBytes(kNode + (kPlaces + 1) * sizeof(void*));
  }
  uint64_t places = entries == 0 ? 0 : 1;
  while (places < entries) places = std::min(2 * places, kPlaces);
  return places == 0 ? 0 : HeapBlockBytes(kHeader + places * sizeof(Entry));
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_HEAP_BYTES_H_

// Strong identifiers of everything that crosses a boundary. A local map's id is a random 64-bit
// number that its agent draws, so ids never collide across restarts; keyframes and map points are
// numbered within their local map. An index is never used twice.
#ifndef CORBSLAM_SLAM_UTIL_IDS_H_
#define CORBSLAM_SLAM_UTIL_IDS_H_

#include <compare>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

namespace corbslam {

struct LocalMapId {
  uint64_t value = 0;  // 0: no local map.

  bool IsValid() const { return value != 0; }
  friend auto operator<=>(const LocalMapId&, const LocalMapId&) = default;
  template <typename H>
  friend H AbslHashValue(H h, const LocalMapId& id) {
    return H::combine(std::move(h), id.value);
  }
};

namespace internal {

template <typename Tag>
struct ItemId {
  static constexpr uint32_t kNoIndex = std::numeric_limits<uint32_t>::max();

  LocalMapId local_map;
  uint32_t index = kNoIndex;

  bool IsValid() const { return local_map.IsValid() && index != kNoIndex; }
  friend auto operator<=>(const ItemId&, const ItemId&) = default;
  template <typename H>
  friend H AbslHashValue(H h, const ItemId& id) {
    return H::combine(std::move(h), id.local_map, id.index);
  }
};

}  // namespace internal

// Default-constructed ids are invalid and mean "none".
using KeyframeId = internal::ItemId<struct KeyframeTag>;
using MapPointId = internal::ItemId<struct MapPointTag>;

// Writes 16 hexadecimal digits: "00c0ffee00c0ffee".
std::string ToString(LocalMapId id);
// Writes the local map and the index: "00c0ffee00c0ffee:12".
std::string ToString(KeyframeId id);
std::string ToString(MapPointId id);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_IDS_H_

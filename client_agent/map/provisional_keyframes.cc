#include "client_agent/map/provisional_keyframes.h"

#include <iterator>
#include <limits>

namespace corbslam::client_agent {

KeyframeId NewestBut(const Map& map, LocalMapId local_map, size_t count) {
  const auto& keyframes = map.keyframes();
  auto it = keyframes.upper_bound({local_map, std::numeric_limits<uint32_t>::max()});
  while (it != keyframes.begin()) {
    --it;
    if (it->first.local_map != local_map) break;
    if (count-- == 0) return it->first;
  }
  return KeyframeId();
}

}  // namespace corbslam::client_agent

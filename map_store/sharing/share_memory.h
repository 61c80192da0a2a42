// Says about how much memory it takes to know what an agent was sent.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARE_MEMORY_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARE_MEMORY_H_

#include <cstdint>

#include "map_store/state/share_state.h"

namespace corbslam::map_store {

// Returns bytes. Sights that several agents have are shared out among them. It looks at a few
// keyframes and multiplies.
uint64_t EstimateMemory(const ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARE_MEMORY_H_

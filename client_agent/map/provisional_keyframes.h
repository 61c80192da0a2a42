// Keyframes that live for tracking and mapping while it isn't known whether they are worth keeping.
#ifndef CORBSLAM_CLIENT_AGENT_MAP_PROVISIONAL_KEYFRAMES_H_
#define CORBSLAM_CLIENT_AGENT_MAP_PROVISIONAL_KEYFRAMES_H_

#include <cstddef>

#include "slam/map/map.h"

namespace corbslam::client_agent {

// The newest so many of a local map's own keyframes are provisional: mapping judges each as it
// leaves them (docs/adr/0012-provisional-keyframes.md).
inline constexpr size_t kProvisionalKeyframes = 6;

// Returns the newest of `local_map`'s keyframes for which `count` newer ones of its are in the map;
// invalid if there is none.
KeyframeId NewestBut(const Map& map, LocalMapId local_map, size_t count);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAP_PROVISIONAL_KEYFRAMES_H_

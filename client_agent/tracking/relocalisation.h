// Finds a frame in the map without knowing where it is.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_RELOCALISATION_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_RELOCALISATION_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "client_agent/map/guarded_map.h"
#include "client_agent/tracking/frame.h"
#include "slam/vocabulary/words.h"

namespace corbslam::client_agent {

// Returns keyframes of the map that look like what has these words, best first. Thread-safe.
using PlaceFinder = std::function<std::vector<KeyframeId>(const Words& words)>;

// Tries the candidates in turn: words, PnP RANSAC, then guided search among the candidate's
// neighbourhood; the first with 50 points that agree is taken (ORB-SLAM, T-RO 2015, V.C). Sets the
// frame's pose and associations. The frame needs words. Deterministic given the seed.
bool RelocaliseFrame(const GuardedMap& map, const PlaceFinder& places, uint64_t seed, Frame& frame);

// Looks for the frame where somebody says that it is: by guided search among the neighbourhoods of
// the keyframes that saw most likely the same; the first with 50 points that agree is taken. Sets
// the frame's pose and associations. Returns false where the map shows nothing of the kind there.
bool RelocaliseNear(const GuardedMap& map, const Rigid3d& camera_from_map, Frame& frame);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_RELOCALISATION_H_

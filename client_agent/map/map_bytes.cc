#include "client_agent/map/map_bytes.h"

namespace corbslam::client_agent {
namespace {

// A keypoint with its descriptor and grid entry, the point that it sees, its part of the words and
// of the places' index, and what the link knows of it.
constexpr uint64_t kKeypointBytes = 150;
// A point with the usual five or six sights of it, its entries in tables, and what the link knows
// of it.
constexpr uint64_t kPointBytes = 700;
// A neighbour in the covisibility graph.
constexpr uint64_t kNeighbourBytes = 32;

}  // namespace

uint64_t EstimateBytes(const Map& map) {
  uint64_t bytes = map.points().size() * kPointBytes;
  for (const auto& [id, keyframe] : map.keyframes()) {
    bytes += sizeof(Keyframe) + sizeof(KeyframePayload);
    bytes += keyframe.points.size() * kKeypointBytes;
    bytes += keyframe.covisible.size() * kNeighbourBytes;
  }
  return bytes;
}

}  // namespace corbslam::client_agent

#include "map_store/view/memory_estimate.h"

#include <algorithm>
#include <cstddef>

namespace corbslam::map_store {
namespace {

// A node of a tree, with the allocator's own bytes.
constexpr uint64_t kNode = 64;
// Of a keypoint beside itself: the point that it sees, its cell of the grid, its word in the bag,
// in the direct index and in the database.
constexpr uint64_t kOfKeypoint = sizeof(MapPointId) + 4 + 8 + 4 + 12;
// Of a sight: an entry of the point's observations, and of the keyframes' covisibility.
constexpr uint64_t kOfObservation = 24;
constexpr uint64_t kObservationsOfAPoint = 5;
constexpr size_t kLookedAt = 16;

uint64_t BytesOf(const Keyframe& keyframe) {
  const uint64_t keypoints = keyframe.keypoints().size();
  return sizeof(Keyframe) + sizeof(KeyframePayload) + 4 * kNode +
         keypoints * (sizeof(Keypoint) + kOfKeypoint) +
         keyframe.descriptors().size() * sizeof(Descriptor);
}

// Keyframes of one local map have about as many keypoints each.
uint64_t MeanKeyframe(const LocalMapState& local_map) {
  uint64_t bytes = 0;
  uint64_t count = 0;
  const size_t step = std::max<size_t>(local_map.arrived.size() / kLookedAt, 1);
  for (size_t i = 0; i < local_map.arrived.size(); i += step) {
    const Keyframe* keyframe = local_map.map.FindKeyframe(local_map.arrived[i]);
    if (keyframe == nullptr) continue;
    bytes += BytesOf(*keyframe);
    ++count;
  }
  if (count > 0) return bytes / count;
  const auto& keyframes = local_map.map.keyframes();
  return keyframes.empty() ? 0 : BytesOf(keyframes.begin()->second);
}

uint64_t BytesOf(const LocalMapState& local_map) {
  constexpr uint64_t kOfPoint =
      sizeof(MapPoint) + 2 * kNode + kObservationsOfAPoint * kOfObservation;
  return local_map.map.keyframes().size() * MeanKeyframe(local_map) +
         local_map.map.points().size() * kOfPoint + local_map.frames.size() * sizeof(TrackedFrame) +
         local_map.arrived.size() * (sizeof(KeyframeId) + kNode) +
         local_map.removed_keyframes.size() * (sizeof(Tombstone) + kNode) +
         (local_map.removed_points.size() + local_map.replaced_points.size()) * kNode +
         local_map.foreign_observations.size() * kNode;
}

}  // namespace

uint64_t EstimateMemory(const MissionState& state) {
  uint64_t bytes = sizeof(MissionState);
  for (const auto& [id, local_map] : state.local_maps) bytes += BytesOf(local_map);
  for (const auto& [name, agent] : state.agents) {
    for (const LocalisedRun& run : agent.track.runs) {
      bytes += sizeof(run) + run.frames.size() * sizeof(TrackedFrame) +
               run.lost_frames_ns.size() * sizeof(int64_t);
    }
  }
  const GlobalLayer& global = state.global;
  bytes += global.keyframes.size() * (sizeof(PlacedKeyframe) + kNode);
  bytes += global.stand_ins.size() * (sizeof(StandIn) + kNode);
  bytes += global.points.size() * (sizeof(PlacedPoint) + sizeof(MapPointId));
  bytes += (global.heirs.size() + global.rejected.size()) * kNode;
  bytes += global.overlaps.entries().size() * (sizeof(Overlap) + kNode);
  return bytes;
}

}  // namespace corbslam::map_store

#include "map_store/view/memory_estimate.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>

#include "slam/util/heap_bytes.h"

namespace corbslam::map_store {
namespace {

// So many keyframes of a local map are looked at.
constexpr size_t kSampled = 8;

// Returns what std::make_shared takes: the count of its users lies beside the value.
template <typename T>
constexpr uint64_t SharedBytes() {
  return HeapBlockBytes(sizeof(T) + 2 * sizeof(void*));
}

uint64_t BytesOf(const KeyframePayload& payload) {
  // The grid has an index a keypoint, and where each of its cells begins.
  constexpr int kCellSide_px = 16;
  const uint64_t keypoints = payload.features.keypoints.size();
  uint64_t cells = 0;
  if (payload.camera != nullptr) {
    const auto along = [](int side_px) {
      return static_cast<uint64_t>(std::max(side_px, 0) / kCellSide_px + 1);
    };
    cells = along(payload.camera->width_px) * along(payload.camera->height_px);
  }
  return SharedBytes<KeyframePayload>() + VectorBytes(payload.features.keypoints) +
         VectorBytes(payload.features.descriptors) + HeapBlockBytes(keypoints * sizeof(uint32_t)) +
         HeapBlockBytes(cells * sizeof(uint32_t));
}

uint64_t BytesOf(const Words& words, uint64_t keypoints) {
  const uint64_t nodes = words.direct_index.size();
  const uint64_t of_node = nodes == 0 ? 0 : (keypoints + nodes - 1) / nodes;
  return SharedBytes<Words>() + VectorBytes(words.bag) + VectorBytes(words.direct_index) +
         nodes * HeapBlockBytes(of_node * sizeof(uint32_t));
}

uint64_t BytesOf(const Keyframe& keyframe) {
  uint64_t bytes = BytesOf(*keyframe.payload) + VectorBytes(keyframe.points) +
                   BtreeBytes<decltype(keyframe.covisible)::value_type>(keyframe.covisible.size()) +
                   BtreeBytes<KeyframeId>(keyframe.children.size()) +
                   BtreeBytes<KeyframeId>(keyframe.loop_edges.size());
  if (keyframe.words != nullptr) bytes += BytesOf(*keyframe.words, keyframe.points.size());
  return bytes;
}

// What was found of some keyframes of a local map, which have about as much each.
struct Sample {
  uint64_t keyframes = 0;
  uint64_t bytes = 0;
  uint64_t sights = 0;  // Of points of the local map.

  // Returns what all of so many have together.
  uint64_t Of(uint64_t all, uint64_t in_sample) const {
    return keyframes == 0 ? 0 : all * in_sample / keyframes;
  }
};

Sample TakeSample(const LocalMapState& local_map) {
  Sample sample;
  const auto& keyframes = local_map.map.keyframes();
  if (keyframes.empty()) return sample;
  const size_t step = std::max<size_t>(local_map.arrived.size() / kSampled, 1);
  for (size_t i = 0; i < std::max<size_t>(local_map.arrived.size(), 1); i += step) {
    auto it = keyframes.end();
    if (i < local_map.arrived.size()) it = keyframes.lower_bound(local_map.arrived[i]);
    const Keyframe& keyframe = (it == keyframes.end() ? keyframes.begin() : it)->second;
    ++sample.keyframes;
    sample.bytes += BytesOf(keyframe);
    sample.sights += static_cast<uint64_t>(std::ranges::count_if(
        keyframe.points, [](const MapPointId& point) { return point.IsValid(); }));
  }
  return sample;
}

template <typename Items>
uint64_t TableBytes(const Items& items) {
  using Item = typename Items::value_type;
  using Indexed = std::pair<const typename Items::key_type, typename Items::mapped_type*>;
  return TreeBytes<Item>(items.size()) + HashTableBytes<Indexed>(items.size());
}

uint64_t BytesOf(const Map& map, const Sample& sample) {
  using Observation = decltype(MapPoint::observations)::value_type;
  const uint64_t keyframes = map.keyframes().size();
  const uint64_t points = map.points().size();
  const uint64_t sights = sample.Of(keyframes, sample.sights);
  const uint64_t seen = points == 0 ? 0 : (sights + points / 2) / points;
  return TableBytes(map.keyframes()) + sample.Of(keyframes, sample.bytes) +
         TableBytes(map.points()) + points * BtreeBytes<Observation>(seen);
}

// The lists of points that follow keyframes grow one by one, twice as long each time.
uint64_t BytesOfFollowers(uint64_t keyframes, uint64_t points) {
  using List = std::pair<const KeyframeId, std::vector<MapPointId>>;
  return HashTableBytes<List>(keyframes) + points * sizeof(MapPointId) * 4 / 3;
}

uint64_t BytesOfForeign(const LocalMapState& local_map) {
  using Observations = decltype(local_map.foreign_observations);
  using Observation = Observations::mapped_type::value_type;
  const auto& foreign = local_map.foreign_observations;
  const size_t step = std::max<size_t>(local_map.arrived.size() / kSampled, 1);
  uint64_t looked_at = 0;
  uint64_t bytes = 0;
  for (size_t i = 0; i < local_map.arrived.size(); i += step) {
    const auto it = foreign.lower_bound(local_map.arrived[i]);
    if (it == foreign.end()) continue;
    ++looked_at;
    bytes += BtreeBytes<Observation>(it->second.size());
  }
  return TreeBytes<Observations::value_type>(foreign.size()) +
         (looked_at == 0 ? 0 : foreign.size() * bytes / looked_at);
}

uint64_t BytesOf(const LocalMapState& local_map) {
  constexpr uint64_t kOfParked = 4 * TreeBytes<ParkedReference>(1);
  const auto removed = [](const auto& items) {
    return TreeBytes<typename std::decay_t<decltype(items)>::value_type>(items.size());
  };
  return sizeof(LocalMapState) + BytesOf(local_map.map, TakeSample(local_map)) +
         BytesOfFollowers(local_map.map.keyframes().size(), local_map.map.points().size()) +
         BytesOfForeign(local_map) + removed(local_map.removed_keyframes) +
         removed(local_map.removed_points) + removed(local_map.replaced_points) +
         removed(local_map.arrival) + VectorBytes(local_map.arrived) +
         VectorBytes(local_map.frames) + VectorBytes(local_map.lost_frames_ns) +
         VectorBytes(local_map.foreign_loop_edges) + local_map.CountParked() * kOfParked +
         local_map.database.HeapBytes() + local_map.changes.HeapBytes();
}

uint64_t BytesOf(const LocalisedTrack& track) {
  uint64_t bytes = VectorBytes(track.runs);
  for (const LocalisedRun& run : track.runs) {
    bytes += VectorBytes(run.frames) + VectorBytes(run.lost_frames_ns);
  }
  return bytes;
}

uint64_t BytesOf(const GlobalLayer& global) {
  uint64_t bytes = TreeBytes<PlacedKeyframes::value_type>(global.keyframes.size()) +
                   BtreeBytes<PlacedPoints::value_type>(global.points.size()) +
                   global.landmarks.HeapBytes() + global.overlaps.HeapBytes() +
                   TreeBytes<decltype(global.heirs)::value_type>(global.heirs.size()) +
                   TreeBytes<RejectedObservations::value_type>(global.rejected.size()) +
                   TreeBytes<decltype(global.stand_ins)::value_type>(global.stand_ins.size()) +
                   TreeBytes<KeyframeId>(global.culled.size()) +
                   TreeBytes<decltype(global.taken_back)::value_type>(global.taken_back.size());
  for (const auto& [id, island] : global.islands) {
    bytes += sizeof(Island) + TreeBytes<KeyframeId>(island.displaced.size() + island.moved.size());
  }
  return bytes;
}

}  // namespace

uint64_t EstimateMemory(const MissionState& state) {
  uint64_t bytes = sizeof(MissionState);
  for (const auto& [id, local_map] : state.local_maps) bytes += BytesOf(local_map);
  for (const auto& [name, agent] : state.agents) bytes += BytesOf(agent.track);
  return bytes + BytesOf(state.global) + state.points.HeapBytes() + state.poses.HeapBytes() +
         state.sights.HeapBytes() + state.told.all();
}

}  // namespace corbslam::map_store

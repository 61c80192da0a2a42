#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/limits.h"
#include "services/convert/work/map_view.h"

namespace corbslam::services {
namespace {

constexpr size_t kPointBytes = 130;
constexpr size_t kObservationBytes = 24;
constexpr size_t kEdgeBytes = 28;
constexpr size_t kPairBytes = 20;

// Index of a kept keypoint among the kept ones; kNotKept for the others.
constexpr uint32_t kNotKept = 0xffffffffu;
using KeypointNumbers = std::vector<uint32_t>;

// Fills chunks and hands over full ones.
class ChunkWriter {
 public:
  ChunkWriter(v1::MapView view, const ChunkSink& sink) : view_(view), sink_(sink) { Begin(); }

  // Returns the chunk to add about `bytes` to; null once the sink has ended the writing.
  v1::MapChunk* Reserve(size_t bytes) {
    if (size_ > 0 && size_ + bytes > kChunkTargetBytes) Flush();
    size_ += bytes;
    return open_ ? &chunk_ : nullptr;
  }
  SlotWriter& slots() { return *slots_; }
  bool open() const { return open_; }

  void Flush() {
    if (size_ > 0 && open_) open_ = sink_(chunk_.SerializeAsString());
    Begin();
  }

 private:
  void Begin() {
    chunk_.Clear();
    chunk_.set_view(view_);
    slots_ = std::make_unique<SlotWriter>(chunk_.mutable_local_maps());
    size_ = 0;
  }

  const v1::MapView view_;
  const ChunkSink& sink_;
  v1::MapChunk chunk_;
  std::unique_ptr<SlotWriter> slots_;
  size_t size_ = 0;
  bool open_ = true;
};

KeypointNumbers NumberKeypoints(const Keyframe& keyframe, bool all) {
  KeypointNumbers numbers(keyframe.keypoints().size(), kNotKept);
  uint32_t next = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (all || keyframe.points[i].IsValid()) numbers[i] = next++;
  }
  return numbers;
}

Features SelectFeatures(const Keyframe& keyframe, const KeypointNumbers& numbers,
                        bool descriptors) {
  Features selected;
  const bool with_descriptors = descriptors && !keyframe.descriptors().empty();
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] == kNotKept) continue;
    selected.keypoints.push_back(keyframe.keypoints()[i]);
    if (with_descriptors) selected.descriptors.push_back(keyframe.descriptors()[i]);
  }
  return selected;
}

void WriteNodes(const Words& words, const KeypointNumbers& numbers, v1::Features* features) {
  auto& nodes = *features->mutable_nodes_plus_one();
  nodes.Resize(features->x_px64_size(), 0);
  for (const NodeFeatures& entry : words.direct_index) {
    for (const uint32_t keypoint : entry.features) {
      if (keypoint >= numbers.size() || numbers[keypoint] == kNotKept) continue;
      nodes[static_cast<int>(numbers[keypoint])] = entry.node + 1;
    }
  }
}

v1::KeyframePayload PayloadToProto(const Keyframe& keyframe, const KeypointNumbers& numbers,
                                   bool descriptors) {
  v1::KeyframePayload proto;
  proto.set_timestamp_ns(keyframe.payload->timestamp_ns);
  proto.set_camera_index(keyframe.payload->camera_index);
  ToProto(SelectFeatures(keyframe, numbers, descriptors), proto.mutable_features());
  if (descriptors && keyframe.words != nullptr) {
    WriteNodes(*keyframe.words, numbers, proto.mutable_features());
  }
  return proto;
}

void WriteCamera(const KeyframePayload& payload, CameraBook& named, v1::MapChunk* chunk,
                 SlotWriter& slots) {
  const LocalMapId local_map = payload.id.local_map;
  if (named.Find(local_map, payload.camera_index) != nullptr) return;
  v1::MapChunk::CameraEntry* entry = chunk->add_cameras();
  entry->set_slot(slots.Slot(local_map));
  entry->set_index(payload.camera_index);
  ToProto(*payload.camera, entry->mutable_camera());
  named.Add(local_map, payload.camera_index, payload.camera).IgnoreError();
}

std::map<KeyframeId, KeypointNumbers> WriteKeyframes(const Map& map, const MapViewContent& content,
                                                     ChunkWriter& writer) {
  CameraBook named;
  std::map<KeyframeId, KeypointNumbers> numbers;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const KeypointNumbers& kept =
        numbers.emplace(id, NumberKeypoints(keyframe, content.all_keypoints)).first->second;
    v1::KeyframePayload payload = PayloadToProto(keyframe, kept, content.descriptors);
    v1::MapChunk* chunk = writer.Reserve(payload.ByteSizeLong() + 250);
    if (chunk == nullptr) return numbers;
    WriteCamera(*keyframe.payload, named, chunk, writer.slots());
    v1::MapChunk::KeyframeEntry* entry = chunk->add_keyframes();
    writer.slots().Write(id, entry->mutable_id());
    *entry->mutable_payload() = std::move(payload);
    ToProto(keyframe.camera_from_map, entry->mutable_camera_from_map());
  }
  return numbers;
}

void WritePointBlock(const std::vector<const MapPoint*>& points, bool looks, ChunkWriter& writer) {
  v1::MapChunk* chunk = writer.Reserve(points.size() * kPointBytes);
  if (chunk == nullptr) return;
  v1::MapChunk::PointColumns* proto = chunk->mutable_points();
  IdColumnWriter ids(writer.slots(), proto->mutable_ids());
  IdColumnWriter references(writer.slots(), proto->mutable_references());
  for (const MapPoint* point : points) {
    ids.Add(point->id);
    references.Add(point->reference);
    for (const double value : point->position_in_map) proto->add_positions(value);
    if (!looks) continue;
    AppendDescriptor(point->descriptor, proto->mutable_descriptors());
    for (const double value : point->normal_in_map) proto->add_normals(value);
    proto->add_min_distances(point->min_distance);
    proto->add_max_distances(point->max_distance);
  }
}

void WritePoints(const Map& map, bool looks, ChunkWriter& writer) {
  constexpr size_t kBlock = kChunkTargetBytes / kPointBytes;
  std::vector<const MapPoint*> block;
  const auto flush = [&] {
    if (block.empty()) return;
    // A chunk can have only one block of columns, so that each block begins another chunk.
    writer.Flush();
    WritePointBlock(block, looks, writer);
    block.clear();
  };
  for (const auto& [id, point] : map.points()) {
    block.push_back(&point);
    if (block.size() == kBlock) flush();
  }
  flush();
}

void WriteObservations(const Map& map, const std::map<KeyframeId, KeypointNumbers>& numbers,
                       ChunkWriter& writer) {
  constexpr size_t kBlock = kChunkTargetBytes / kObservationBytes;
  struct Sighting {
    MapPointId point;
    KeyframeId keyframe;
    uint32_t keypoint = 0;
  };
  std::vector<Sighting> block;
  const auto flush = [&] {
    if (block.empty()) return;
    writer.Flush();
    v1::MapChunk* chunk = writer.Reserve(block.size() * kObservationBytes);
    if (chunk != nullptr) {
      v1::ObservationChanges* proto = chunk->mutable_observations();
      IdColumnWriter points(writer.slots(), proto->mutable_points());
      IdColumnWriter keyframes(writer.slots(), proto->mutable_keyframes());
      for (const Sighting& sighting : block) {
        points.Add(sighting.point);
        keyframes.Add(sighting.keyframe);
        proto->add_keypoints(sighting.keypoint);
      }
    }
    block.clear();
  };
  for (const auto& [id, point] : map.points()) {
    for (const auto& [keyframe, keypoint] : point.observations) {
      const auto it = numbers.find(keyframe);
      if (it == numbers.end()) continue;
      block.push_back({id, keyframe, it->second[keypoint]});
      if (block.size() == kBlock) flush();
    }
  }
  flush();
}

void WriteEdge(KeyframeId a, KeyframeId b, bool loop, ChunkWriter& writer) {
  v1::MapChunk* chunk = writer.Reserve(kEdgeBytes);
  if (chunk == nullptr) return;
  v1::MapChunk::Edge* edge = chunk->add_edges();
  writer.slots().Write(a, edge->mutable_a());
  writer.slots().Write(b, edge->mutable_b());
  edge->set_loop(loop);
}

void WriteEdges(const Map& map, ChunkWriter& writer) {
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (map.FindKeyframe(keyframe.parent) != nullptr) WriteEdge(id, keyframe.parent, false, writer);
    for (const KeyframeId other : keyframe.loop_edges) {
      if (id < other && map.FindKeyframe(other) != nullptr) WriteEdge(id, other, true, writer);
    }
  }
}

struct Covisible {
  KeyframeId a;
  KeyframeId b;
  int weight = 0;
};

void WriteCovisibilityBlock(const std::vector<Covisible>& pairs, ChunkWriter& writer) {
  v1::MapChunk* chunk = writer.Reserve(pairs.size() * kPairBytes);
  if (chunk == nullptr) return;
  v1::MapChunk::CovisibilityColumns* proto = chunk->mutable_covisibility();
  IdColumnWriter a(writer.slots(), proto->mutable_a());
  IdColumnWriter b(writer.slots(), proto->mutable_b());
  for (const Covisible& pair : pairs) {
    a.Add(pair.a);
    b.Add(pair.b);
    proto->add_weights(static_cast<uint32_t>(pair.weight));
  }
}

void WriteCovisibility(const Map& map, ChunkWriter& writer) {
  constexpr size_t kBlock = kChunkTargetBytes / kPairBytes;
  std::vector<Covisible> block;
  const auto flush = [&] {
    if (block.empty()) return;
    writer.Flush();
    WriteCovisibilityBlock(block, writer);
    block.clear();
  };
  for (const auto& [id, keyframe] : map.keyframes()) {
    for (const auto& [other, weight] : keyframe.covisible) {
      if (id < other) block.push_back({id, other, weight});
      if (block.size() == kBlock) flush();
    }
  }
  flush();
}

}  // namespace

void WriteNodes(const Words& words, v1::Features* features) {
  KeypointNumbers all(static_cast<size_t>(features->x_px64_size()));
  std::iota(all.begin(), all.end(), 0u);
  WriteNodes(words, all, features);
}

bool WriteMapView(const Map& map, v1::MapView view, const MapViewContent& content,
                  const ChunkSink& sink) {
  ChunkWriter writer(view, sink);
  const auto numbers = WriteKeyframes(map, content, writer);
  if (!writer.open()) return false;
  WritePoints(map, content.descriptors, writer);
  WriteObservations(map, numbers, writer);
  WriteEdges(map, writer);
  if (content.covisibility) WriteCovisibility(map, writer);
  writer.Flush();
  return writer.open();
}

}  // namespace corbslam::services

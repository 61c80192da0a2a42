#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "services/convert/columns.h"
#include "services/convert/errors.h"
#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/limits.h"
#include "services/convert/work/map_view.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::Status ReadCameras(const v1::MapChunk& chunk, const SlotReader& slots, CameraBook& cameras) {
  for (const v1::MapChunk::CameraEntry& entry : chunk.cameras()) {
    ASSIGN_OR_RETURN(const LocalMapId local_map, slots.LocalMap(entry.slot()));
    ASSIGN_OR_RETURN(const Camera camera, FromProto(entry.camera()));
    RETURN_IF_ERROR(cameras.Add(local_map, entry.index(), std::make_shared<const Camera>(camera)));
  }
  return absl::OkStatus();
}

absl::Status ReadKeyframe(const v1::MapChunk::KeyframeEntry& entry, KeyframeId id,
                          const CameraBook& cameras, bool descriptors_optional, Map& map) {
  Keyframe keyframe;
  ASSIGN_OR_RETURN(keyframe.payload, FromProto(entry.payload(), id, cameras, descriptors_optional));
  ASSIGN_OR_RETURN(keyframe.camera_from_map, FromProto(entry.camera_from_map()));
  keyframe.words = ReadNodes(entry.payload().features());
  if (!map.AddKeyframe(std::move(keyframe))) return absl::InvalidArgumentError("came twice");
  return absl::OkStatus();
}

absl::Status ReadKeyframes(const v1::MapChunk& chunk, const SlotReader& slots,
                           const CameraBook& cameras, bool descriptors_optional, Map& map) {
  for (const v1::MapChunk::KeyframeEntry& entry : chunk.keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, slots.Keyframe(entry.id()));
    if (!id.IsValid()) return absl::InvalidArgumentError("a keyframe has no id");
    RETURN_IF_ERROR(Locate(ReadKeyframe(entry, id, cameras, descriptors_optional, map),
                           absl::StrCat("keyframe ", ToString(id))));
  }
  return absl::OkStatus();
}

absl::Status CheckPointLengths(const v1::MapChunk::PointColumns& proto, int64_t count, bool looks) {
  if (proto.positions_size() != 3 * count) {
    return BadLength("points.positions", proto.positions_size(), 3 * count);
  }
  if (proto.references().index_deltas_size() != count) {
    return BadLength("points.references", proto.references().index_deltas_size(), count);
  }
  if (!looks) return absl::OkStatus();
  const auto descriptor_bytes = static_cast<int64_t>(proto.descriptors().size());
  if (descriptor_bytes != 32 * count) {
    return BadLength("points.descriptors", descriptor_bytes, 32 * count);
  }
  if (proto.normals_size() != 3 * count) {
    return BadLength("points.normals", proto.normals_size(), 3 * count);
  }
  if (proto.min_distances_size() != count) {
    return BadLength("points.min_distances", proto.min_distances_size(), count);
  }
  if (proto.max_distances_size() != count) {
    return BadLength("points.max_distances", proto.max_distances_size(), count);
  }
  return absl::OkStatus();
}

Eigen::Vector3d ReadVector(const google::protobuf::RepeatedField<double>& column, int i) {
  return {column[3 * i], column[3 * i + 1], column[3 * i + 2]};
}

absl::Status ReadPoint(const v1::MapChunk::PointColumns& proto, int i, bool looks,
                       MapPoint& point) {
  point.position_in_map = ReadVector(proto.positions(), i);
  RETURN_IF_ERROR(CheckPosition(point.position_in_map));
  if (!looks) return absl::OkStatus();
  point.descriptor = DescriptorFromBytes(proto.descriptors(), static_cast<size_t>(i));
  const Eigen::Vector3d normal = ReadVector(proto.normals(), i);
  RETURN_IF_ERROR(CheckNormal(normal).status());
  // The values are kept to the bit, so that a worker elsewhere computes what one in this process
  // does.
  point.normal_in_map = normal;
  point.min_distance = proto.min_distances(i);
  point.max_distance = proto.max_distances(i);
  if (!(point.min_distance >= 0 && point.max_distance >= point.min_distance &&
        std::isfinite(point.max_distance))) {
    return absl::InvalidArgumentError(absl::StrCat("distances are ", point.min_distance, " to ",
                                                   point.max_distance,
                                                   ", must be finite, at least 0 and in order"));
  }
  return absl::OkStatus();
}

absl::Status ReadPoints(const v1::MapChunk::PointColumns& proto, const SlotReader& slots,
                        bool looks_optional, Map& map) {
  ASSIGN_OR_RETURN(const std::vector<MapPointId> ids, slots.Points(proto.ids(), "points.ids"));
  const bool looks = !looks_optional || !proto.descriptors().empty();
  RETURN_IF_ERROR(CheckPointLengths(proto, static_cast<int64_t>(ids.size()), looks));
  ASSIGN_OR_RETURN(const std::vector<KeyframeId> references,
                   slots.Keyframes(proto.references(), "points.references", /*may_be_none=*/true));
  for (size_t i = 0; i < ids.size(); ++i) {
    MapPoint point;
    point.id = ids[i];
    point.reference = references[i];
    RETURN_IF_ERROR(Locate(ReadPoint(proto, static_cast<int>(i), looks, point),
                           absl::StrCat("map point ", ToString(point.id))));
    if (!map.AddPoint(std::move(point))) {
      return absl::InvalidArgumentError(
          absl::StrCat("map point ", ToString(ids[i]), " came twice"));
    }
  }
  return absl::OkStatus();
}

absl::Status ReadGraph(const v1::MapChunk& chunk, const SlotReader& slots, Map& map) {
  ASSIGN_OR_RETURN(const std::vector<ObservationChange> observations,
                   ReadObservations(chunk.observations(), slots));
  for (const ObservationChange& seen : observations) {
    if (seen.kind == ObservationChange::Kind::kAdded &&
        map.AddObservation(seen.point, seen.keyframe, seen.keypoint)) {
      continue;
    }
    return absl::InvalidArgumentError(
        absl::StrCat("observation of map point ", ToString(seen.point), " by keypoint ",
                     seen.keypoint, " of keyframe ", ToString(seen.keyframe),
                     " is a removal, of something unknown, or contradicts another one"));
  }
  for (const v1::MapChunk::Edge& edge : chunk.edges()) {
    ASSIGN_OR_RETURN(const KeyframeId a, slots.Keyframe(edge.a()));
    ASSIGN_OR_RETURN(const KeyframeId b, slots.Keyframe(edge.b()));
    if (edge.loop() ? map.AddLoopEdge(a, b) : map.SetParent(a, b)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(edge.loop() ? "loop" : "tree", " edge ", ToString(a), " to ", ToString(b),
                     " is of something unknown, came twice, or makes a cycle"));
  }
  return absl::OkStatus();
}

absl::Status ReadCovisibility(const v1::MapChunk::CovisibilityColumns& proto,
                              const SlotReader& slots, Map& map) {
  ASSIGN_OR_RETURN(const std::vector<KeyframeId> a, slots.Keyframes(proto.a(), "covisibility.a"));
  ASSIGN_OR_RETURN(const std::vector<KeyframeId> b, slots.Keyframes(proto.b(), "covisibility.b"));
  const auto count = static_cast<int64_t>(a.size());
  if (b.size() != a.size()) {
    return BadLength("covisibility.b", static_cast<int64_t>(b.size()), count);
  }
  if (proto.weights_size() != count) {
    return BadLength("covisibility.weights", proto.weights_size(), count);
  }
  for (size_t i = 0; i < a.size(); ++i) {
    const auto weight = static_cast<int64_t>(proto.weights(static_cast<int>(i)));
    if (weight < 1 || weight > kMaxKeypoints) {
      return OutOfRange("covisibility.weights", weight, 1, kMaxKeypoints);
    }
    if (map.SetCovisibility(a[i], b[i], static_cast<int>(weight))) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("covisibility of keyframes ", ToString(a[i]), " and ", ToString(b[i]),
                     ": one is unknown, they are the same, or this view counts its own"));
  }
  return absl::OkStatus();
}

}  // namespace

std::shared_ptr<const Words> ReadNodes(const v1::Features& features) {
  if (features.nodes_plus_one_size() == 0) return nullptr;
  std::map<uint32_t, std::vector<uint32_t>> by_node;
  for (int i = 0; i < features.nodes_plus_one_size(); ++i) {
    const uint32_t node_plus_one = features.nodes_plus_one(i);
    if (node_plus_one != 0) by_node[node_plus_one - 1].push_back(static_cast<uint32_t>(i));
  }
  auto words = std::make_shared<Words>();
  for (auto& [node, keypoints] : by_node) {
    words->direct_index.push_back({node, std::move(keypoints)});
  }
  return words;
}

absl::Status MapViewReader::Add(const v1::MapChunk& chunk) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(chunk.local_maps()));
  RETURN_IF_ERROR(ReadCameras(chunk, slots, cameras_));
  RETURN_IF_ERROR(ReadKeyframes(chunk, slots, cameras_, descriptors_optional_, map_));
  RETURN_IF_ERROR(ReadPoints(chunk.points(), slots, descriptors_optional_, map_));
  RETURN_IF_ERROR(ReadGraph(chunk, slots, map_));
  return ReadCovisibility(chunk.covisibility(), slots, map_);
}

}  // namespace corbslam::services

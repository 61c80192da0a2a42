#include "services/convert/map_update.h"

#include <string>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "services/convert/columns.h"
#include "services/convert/errors.h"
#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/limits.h"
#include "services/convert/parts.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// An entry of a column takes at most so many bytes.
constexpr size_t kFullPointBytes = 90;
constexpr size_t kLightPointBytes = 30;
constexpr size_t kIdBytes = 12;
constexpr size_t kObservationBytes = 24;
constexpr size_t kFrameBytes = 52;
constexpr size_t kTimeBytes = 10;
constexpr size_t kMotionBytes = 120;

using Writer = PartWriter<v1::MapUpdateBatch>;

void WriteCameras(const MapUpdateBatch& batch, CameraBook& sent, v1::MapUpdateBatch& part) {
  part.set_first_camera_index(batch.first_camera_index);
  for (size_t i = 0; i < batch.cameras.size(); ++i) {
    ToProto(*batch.cameras[i], part.add_cameras());
    const auto index = batch.first_camera_index + static_cast<uint32_t>(i);
    sent.Add(batch.local_map, index, batch.cameras[i]).IgnoreError();
  }
  for (const RecordedCamera& recorded : batch.recorded_cameras) {
    ToProto(recorded, part.add_recorded_cameras());
  }
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    const KeyframePayload& payload = *keyframe.payload;
    if (sent.Find(batch.local_map, payload.camera_index) != nullptr) continue;
    v1::IndexedCamera* known = part.add_known_cameras();
    known->set_index(payload.camera_index);
    ToProto(*payload.camera, known->mutable_camera());
    sent.Add(batch.local_map, payload.camera_index, payload.camera).IgnoreError();
  }
}

void WriteKeyframes(const MapUpdateBatch& batch, FeatureForm form, Writer& writer) {
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    v1::FullKeyframe proto;
    proto.set_index(keyframe.payload->id.index);
    ToProto(*keyframe.payload, proto.mutable_payload(), form);
    ToProto(keyframe.camera_from_local, proto.mutable_camera_from_local());
    writer.Reserve(proto.ByteSizeLong() + kMotionBytes);
    if (keyframe.parent.IsValid()) writer.slots().Write(keyframe.parent, proto.mutable_parent());
    *writer.part().add_full_keyframes() = std::move(proto);
  }
}

void WriteLightKeyframes(const MapUpdateBatch& batch, Writer& writer) {
  for (const LightKeyframe& keyframe : batch.light_keyframes) {
    writer.Reserve(kMotionBytes);
    v1::LightKeyframe* proto = writer.part().add_light_keyframes();
    proto->set_index(keyframe.id.index);
    ToProto(keyframe.camera_from_local, proto->mutable_camera_from_local());
    if (keyframe.parent.IsValid()) writer.slots().Write(keyframe.parent, proto->mutable_parent());
  }
}

void WriteReplacements(const MapUpdateBatch& batch, Writer& writer) {
  writer.Spread(batch.replacements, 2 * kIdBytes,
                [&](std::span<const PointReplacement> replacements) {
                  v1::PointReplacements* proto = writer.part().mutable_replacements();
                  IdColumnWriter replaced(writer.slots(), proto->mutable_replaced());
                  IdColumnWriter survivors(writer.slots(), proto->mutable_survivors());
                  for (const PointReplacement& replacement : replacements) {
                    replaced.Add(replacement.replaced);
                    survivors.Add(replacement.survivor);
                  }
                });
}

void WriteRemovalsAndLoops(const MapUpdateBatch& batch, Writer& writer) {
  for (const KeyframeRemoval& removal : batch.removed_keyframes) {
    writer.Reserve(kMotionBytes);
    v1::KeyframeRemoval* proto = writer.part().add_removed_keyframes();
    proto->set_index(removal.id.index);
    if (!removal.parent.IsValid()) continue;
    writer.slots().Write(removal.parent, proto->mutable_parent());
    ToProto(removal.parent_from_removed, proto->mutable_parent_from_removed());
  }
  for (const LoopEdge& edge : batch.loop_edges) {
    writer.Reserve(kMotionBytes);
    v1::LoopEdge* proto = writer.part().add_loop_edges();
    writer.slots().Write(edge.a, proto->mutable_a());
    writer.slots().Write(edge.b, proto->mutable_b());
    ToProto(edge.b_from_a, proto->mutable_b_from_a());
  }
}

// Returns the descriptors of the keyframes of `batch` that are in `part`.
KeyframeDescriptors DescriptorsOf(const MapUpdateBatch& batch, const v1::MapUpdateBatch& part) {
  absl::flat_hash_set<uint32_t> there;
  for (const v1::FullKeyframe& keyframe : part.full_keyframes()) there.insert(keyframe.index());
  KeyframeDescriptors descriptors;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    const KeyframePayload& payload = *keyframe.payload;
    if (there.contains(payload.id.index)) descriptors[payload.id] = payload.features.descriptors;
  }
  return descriptors;
}

void WriteFullPoints(const MapUpdateBatch& batch, FeatureForm form, Writer& writer) {
  writer.Spread(batch.full_points, kFullPointBytes, [&](auto points) {
    v1::FullMapPoints* proto = writer.part().mutable_full_points();
    WritePoints(points, writer.slots(), proto);
    if (form == FeatureForm::kCoded)
      CodeDescriptors(points, DescriptorsOf(batch, writer.part()), proto);
  });
}

void WriteColumns(const MapUpdateBatch& batch, Writer& writer) {
  WriteLightKeyframes(batch, writer);
  writer.Spread(batch.light_points, kLightPointBytes, [&](auto points) {
    WritePoints(points, writer.slots(), writer.part().mutable_light_points());
  });
  WriteReplacements(batch, writer);
  writer.Spread(batch.observations, kObservationBytes, [&](auto changes) {
    WriteObservations(changes, writer.slots(), writer.part().mutable_observations());
  });
  writer.Spread(batch.removed_points, kIdBytes, [&](auto ids) {
    WriteIds(ids, writer.slots(), writer.part().mutable_removed_points());
  });
  WriteRemovalsAndLoops(batch, writer);
  writer.Spread(batch.tracked_frames, kFrameBytes, [&](auto frames) {
    WriteFrames(frames, writer.slots(), writer.part().mutable_tracked_frames());
  });
  writer.Spread(batch.lost_frames_ns, kTimeBytes, [&](auto times) {
    WriteTimes(times, writer.part().mutable_lost_frame_deltas_ns());
  });
}

absl::StatusOr<KeyframeId> OwnKeyframe(uint32_t index, LocalMapId local_map) {
  if (index == KeyframeId::kNoIndex) {
    return OutOfRange("index", index, 0u, KeyframeId::kNoIndex - 1);
  }
  return KeyframeId{local_map, index};
}

absl::Status ReadCameras(const v1::MapUpdateBatch& proto, CameraBook& cameras,
                         MapUpdateBatch& batch) {
  batch.first_camera_index = proto.first_camera_index();
  if (batch.first_camera_index > kMaxCameraIndex) {
    return OutOfRange("first_camera_index", batch.first_camera_index, 0u, kMaxCameraIndex);
  }
  for (int i = 0; i < proto.cameras_size(); ++i) {
    ASSIGN_OR_RETURN(const Camera camera, FromProto(proto.cameras(i)));
    batch.cameras.push_back(std::make_shared<const Camera>(camera));
    RETURN_IF_ERROR(cameras.Add(batch.local_map,
                                batch.first_camera_index + static_cast<uint32_t>(i),
                                batch.cameras.back()));
  }
  for (const v1::RecordedCamera& recorded : proto.recorded_cameras()) {
    ASSIGN_OR_RETURN(batch.recorded_cameras.emplace_back(), FromProto(recorded));
  }
  for (const v1::IndexedCamera& known : proto.known_cameras()) {
    ASSIGN_OR_RETURN(const Camera camera, FromProto(known.camera()));
    RETURN_IF_ERROR(
        cameras.Add(batch.local_map, known.index(), std::make_shared<const Camera>(camera)));
  }
  return absl::OkStatus();
}

template <typename Proto>
absl::Status ReadPoseAndParent(const Proto& proto, const SlotReader& slots, Rigid3d& pose,
                               KeyframeId& parent) {
  ASSIGN_OR_RETURN(pose, FromProto(proto.camera_from_local()));
  if (!proto.has_parent()) return absl::OkStatus();
  ASSIGN_OR_RETURN(parent, slots.Keyframe(proto.parent()));
  return absl::OkStatus();
}

absl::Status ReadFullKeyframe(const v1::FullKeyframe& proto, KeyframeId id, const SlotReader& slots,
                              const CameraBook& cameras, FullKeyframe& keyframe) {
  const std::string& code = proto.payload().features().coded();
  if (!code.empty()) keyframe.code = std::make_shared<const std::string>(code);
  ASSIGN_OR_RETURN(keyframe.payload, FromProto(proto.payload(), id, cameras,
                                               /*descriptors_optional=*/false, keyframe.code));
  return ReadPoseAndParent(proto, slots, keyframe.camera_from_local, keyframe.parent);
}

absl::Status ReadKeyframes(const v1::MapUpdateBatch& proto, const SlotReader& slots,
                           const CameraBook& cameras, MapUpdateBatch& batch) {
  for (const v1::FullKeyframe& keyframe : proto.full_keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, OwnKeyframe(keyframe.index(), batch.local_map));
    RETURN_IF_ERROR(
        Locate(ReadFullKeyframe(keyframe, id, slots, cameras, batch.full_keyframes.emplace_back()),
               absl::StrCat("full keyframe ", ToString(id))));
  }
  for (const v1::LightKeyframe& keyframe : proto.light_keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, OwnKeyframe(keyframe.index(), batch.local_map));
    LightKeyframe& light = batch.light_keyframes.emplace_back();
    light.id = id;
    RETURN_IF_ERROR(
        Locate(ReadPoseAndParent(keyframe, slots, light.camera_from_local, light.parent),
               absl::StrCat("light keyframe ", ToString(id))));
  }
  return absl::OkStatus();
}

absl::Status ReadPoints(const v1::MapUpdateBatch& proto, const SlotReader& slots,
                        MapUpdateBatch& batch) {
  auto full_points = ReadFullPoints(proto.full_points(), slots, DescriptorsOf(batch, proto));
  if (!full_points.ok()) return Locate(full_points.status(), "full_points");
  batch.full_points = *std::move(full_points);
  ASSIGN_OR_RETURN(batch.light_points, ReadLightPoints(proto.light_points(), slots));
  ASSIGN_OR_RETURN(batch.removed_points, slots.Points(proto.removed_points(), "removed_points"));
  ASSIGN_OR_RETURN(const std::vector<MapPointId> replaced,
                   slots.Points(proto.replacements().replaced(), "replacements.replaced"));
  ASSIGN_OR_RETURN(const std::vector<MapPointId> survivors,
                   slots.Points(proto.replacements().survivors(), "replacements.survivors"));
  if (replaced.size() != survivors.size()) {
    return BadLength("replacements.survivors", static_cast<int64_t>(survivors.size()),
                     static_cast<int64_t>(replaced.size()));
  }
  for (size_t i = 0; i < replaced.size(); ++i) {
    if (replaced[i] == survivors[i]) {
      return absl::InvalidArgumentError(
          absl::StrCat("replacements: ", ToString(replaced[i]), " replaces itself"));
    }
    batch.replacements.push_back({replaced[i], survivors[i]});
  }
  std::vector<MapPointId> own = replaced;
  for (const FullMapPoint& point : batch.full_points) own.push_back(point.id);
  for (const LightMapPoint& point : batch.light_points) own.push_back(point.id);
  own.insert(own.end(), batch.removed_points.begin(), batch.removed_points.end());
  return CheckOwned(own, batch.local_map, "a change of points");
}

absl::StatusOr<KeyframeRemoval> ReadRemoval(const v1::KeyframeRemoval& proto, LocalMapId local_map,
                                            const SlotReader& slots) {
  KeyframeRemoval removal;
  ASSIGN_OR_RETURN(removal.id, OwnKeyframe(proto.index(), local_map));
  if (!proto.has_parent()) return removal;
  ASSIGN_OR_RETURN(removal.parent, slots.Keyframe(proto.parent()));
  ASSIGN_OR_RETURN(removal.parent_from_removed, FromProto(proto.parent_from_removed()));
  return removal;
}

absl::StatusOr<LoopEdge> ReadLoopEdge(const v1::LoopEdge& proto, const SlotReader& slots) {
  LoopEdge edge;
  ASSIGN_OR_RETURN(edge.a, slots.Keyframe(proto.a()));
  ASSIGN_OR_RETURN(edge.b, slots.Keyframe(proto.b()));
  if (!edge.a.IsValid() || !edge.b.IsValid() || edge.a == edge.b) {
    return absl::InvalidArgumentError("must name two keyframes");
  }
  ASSIGN_OR_RETURN(edge.b_from_a, FromProto(proto.b_from_a()));
  return edge;
}

absl::Status ReadGraph(const v1::MapUpdateBatch& proto, const SlotReader& slots,
                       MapUpdateBatch& batch) {
  auto observations = ReadObservations(proto.observations(), slots);
  if (!observations.ok()) return Locate(observations.status(), "observations");
  batch.observations = *std::move(observations);
  std::vector<KeyframeId> observers;
  for (const ObservationChange& change : batch.observations) observers.push_back(change.keyframe);
  RETURN_IF_ERROR(CheckOwned(observers, batch.local_map, "observations"));
  for (int i = 0; i < proto.removed_keyframes_size(); ++i) {
    auto removal = ReadRemoval(proto.removed_keyframes(i), batch.local_map, slots);
    if (!removal.ok()) return Locate(removal.status(), absl::StrCat("removed_keyframes[", i, "]"));
    batch.removed_keyframes.push_back(*removal);
  }
  for (int i = 0; i < proto.loop_edges_size(); ++i) {
    auto edge = ReadLoopEdge(proto.loop_edges(i), slots);
    if (!edge.ok()) return Locate(edge.status(), absl::StrCat("loop_edges[", i, "]"));
    batch.loop_edges.push_back(*edge);
  }
  return absl::OkStatus();
}

// Counts the entries of all fields, before any is converted.
size_t CountItems(const v1::MapUpdateBatch& proto) {
  const int64_t points = int64_t{proto.full_points().ids().index_deltas_size()} +
                         proto.light_points().ids().index_deltas_size() +
                         proto.removed_points().index_deltas_size() +
                         proto.replacements().replaced().index_deltas_size() +
                         proto.replacements().survivors().index_deltas_size();
  const int64_t keyframes = int64_t{proto.full_keyframes_size()} + proto.light_keyframes_size() +
                            proto.removed_keyframes_size() + proto.loop_edges_size() +
                            proto.cameras_size() + proto.known_cameras_size() +
                            proto.recorded_cameras_size();
  const int64_t others = int64_t{proto.observations().points().index_deltas_size()} +
                         proto.tracked_frames().timestamp_deltas_ns_size() +
                         proto.lost_frame_deltas_ns_size();
  return static_cast<size_t>(points + keyframes + others);
}

void Append(MapUpdateBatch& batch, MapUpdateBatch& part) {
  if (batch.cameras.empty()) batch.first_camera_index = part.first_camera_index;
  AppendAll(batch.cameras, part.cameras);
  AppendAll(batch.recorded_cameras, part.recorded_cameras);
  AppendAll(batch.full_keyframes, part.full_keyframes);
  AppendAll(batch.full_points, part.full_points);
  AppendAll(batch.light_keyframes, part.light_keyframes);
  AppendAll(batch.light_points, part.light_points);
  AppendAll(batch.replacements, part.replacements);
  AppendAll(batch.observations, part.observations);
  AppendAll(batch.removed_points, part.removed_points);
  AppendAll(batch.removed_keyframes, part.removed_keyframes);
  AppendAll(batch.loop_edges, part.loop_edges);
  AppendAll(batch.tracked_frames, part.tracked_frames);
  AppendAll(batch.lost_frames_ns, part.lost_frames_ns);
  batch.points_follow |= part.points_follow;
  batch.closes_local_map |= part.closes_local_map;
}

}  // namespace

std::vector<v1::MapUpdateBatch> ToProto(const MapUpdateBatch& batch, CameraBook& sent,
                                        size_t part_bytes, FeatureForm form) {
  Writer writer(part_bytes, [&](v1::MapUpdateBatch& part) {
    part.set_local_map(batch.local_map.value);
    part.set_number(batch.number);
    part.set_points_follow(batch.points_follow);
    part.set_continues(true);
    return SlotWriter(part.mutable_other_local_maps(), batch.local_map);
  });
  WriteCameras(batch, sent, writer.part());
  WriteKeyframes(batch, form, writer);
  WriteFullPoints(batch, form, writer);
  WriteColumns(batch, writer);
  writer.part().set_closes_local_map(batch.closes_local_map);
  writer.part().clear_continues();
  return std::move(writer).Take();
}

absl::StatusOr<MapUpdateBatch> FromProto(const v1::MapUpdateBatch& proto, CameraBook& cameras) {
  MapUpdateBatch batch;
  batch.local_map = {proto.local_map()};
  if (!batch.local_map.IsValid()) return absl::InvalidArgumentError("batch.local_map is 0");
  if (proto.number() == 0)
    return absl::InvalidArgumentError("batch.number is 0, must be 1 or more");
  batch.number = proto.number();
  const auto read = [&]() -> absl::Status {
    ASSIGN_OR_RETURN(const SlotReader slots,
                     SlotReader::Create(proto.other_local_maps(), batch.local_map));
    RETURN_IF_ERROR(ReadCameras(proto, cameras, batch));
    RETURN_IF_ERROR(ReadKeyframes(proto, slots, cameras, batch));
    RETURN_IF_ERROR(ReadPoints(proto, slots, batch));
    RETURN_IF_ERROR(ReadGraph(proto, slots, batch));
    ASSIGN_OR_RETURN(batch.tracked_frames, ReadFrames(proto.tracked_frames(), slots));
    ASSIGN_OR_RETURN(batch.lost_frames_ns,
                     ReadTimes(proto.lost_frame_deltas_ns(), "lost_frame_deltas_ns"));
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(Locate(
      read(), absl::StrCat("batch ", batch.number, " of local map ", ToString(batch.local_map))));
  batch.points_follow = proto.points_follow();
  batch.closes_local_map = proto.closes_local_map();
  return batch;
}

size_t UncodedBytes(const v1::MapUpdateBatch& proto) {
  size_t bytes = proto.ByteSizeLong();
  for (const v1::FullKeyframe& keyframe : proto.full_keyframes()) {
    const v1::Features& features = keyframe.payload().features();
    bytes += UncodedBytes(features) - features.ByteSizeLong();
  }
  return bytes;
}

absl::StatusOr<std::optional<MapUpdateBatch>> BatchAssembler::Add(const v1::MapUpdateBatch& part,
                                                                  CameraBook& cameras) {
  bytes_ += UncodedBytes(part);
  items_ += CountItems(part);
  if (bytes_ > kMaxUpdateBytes || items_ > kMaxUpdateItems) {
    return absl::ResourceExhaustedError(
        absl::StrCat("batch ", part.number(), " of local map ",
                     ToString(LocalMapId{part.local_map()}), " has ", bytes_, " bytes and ", items_,
                     " items; the limits are ", kMaxUpdateBytes, " and ", kMaxUpdateItems));
  }
  ASSIGN_OR_RETURN(MapUpdateBatch read, FromProto(part, cameras));
  if (!started_) {
    started_ = std::move(read);
  } else if (started_->local_map != read.local_map || started_->number != read.number) {
    return absl::InvalidArgumentError(absl::StrCat(
        "batch ", started_->number, " of local map ", ToString(started_->local_map),
        " is unfinished, but batch ", read.number, " of ", ToString(read.local_map), " came"));
  } else {
    Append(*started_, read);
  }
  if (part.continues()) return std::nullopt;
  bytes_ = 0;
  items_ = 0;
  return std::exchange(started_, std::nullopt);
}

}  // namespace corbslam::services

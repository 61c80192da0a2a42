#include "services/convert/shared_update.h"

#include <algorithm>
#include <string>
#include <utility>

#include "services/convert/columns.h"
#include "services/convert/errors.h"
#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/limits.h"
#include "services/convert/parts.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// One entry takes at most so many bytes.
constexpr size_t kFullPointBytes = 90;
constexpr size_t kLightPointBytes = 30;
constexpr size_t kIdBytes = 12;
constexpr size_t kObservationBytes = 24;
constexpr size_t kPoseBytes = 120;

using Writer = PartWriter<v1::SharedUpdate>;

void WriteCamera(const KeyframePayload& payload, CameraBook& sent, Writer& writer) {
  const LocalMapId local_map = payload.id.local_map;
  if (sent.Find(local_map, payload.camera_index) != nullptr) return;
  v1::SharedCamera* proto = writer.part().add_cameras();
  proto->set_slot(writer.slots().Slot(local_map));
  proto->set_index(payload.camera_index);
  ToProto(*payload.camera, proto->mutable_camera());
  sent.Add(local_map, payload.camera_index, payload.camera).IgnoreError();
}

void WriteKeyframe(const SharedKeyframe& keyframe, FeatureForm form, CameraBook& sent,
                   Writer& writer) {
  v1::SharedKeyframe proto;
  ToProto(*keyframe.payload, proto.mutable_payload(), form);
  ToProto(keyframe.camera_from_global, proto.mutable_camera_from_global());
  writer.Reserve(proto.ByteSizeLong() + kPoseBytes + keyframe.points.size() * kIdBytes);
  WriteCamera(*keyframe.payload, sent, writer);
  writer.slots().Write(keyframe.payload->id, proto.mutable_id());
  if (keyframe.parent.IsValid()) writer.slots().Write(keyframe.parent, proto.mutable_parent());
  IdColumnWriter points(writer.slots(), proto.mutable_points());
  uint32_t last = 0;
  for (uint32_t i = 0; i < keyframe.points.size(); ++i) {
    if (!keyframe.points[i].IsValid()) continue;
    points.Add(keyframe.points[i]);
    proto.add_keypoint_deltas(i - last);
    last = i;
  }
  *writer.part().add_keyframes() = std::move(proto);
}

// Returns the descriptors of the last `in_part` of `keyframes`.
KeyframeDescriptors DescriptorsOf(const std::vector<SharedKeyframe>& keyframes, int in_part) {
  KeyframeDescriptors descriptors;
  const auto count = static_cast<size_t>(in_part);
  for (size_t i = keyframes.size() - count; i < keyframes.size(); ++i) {
    descriptors[keyframes[i].payload->id] = keyframes[i].payload->features.descriptors;
  }
  return descriptors;
}

void WriteFullPoints(const SharedUpdate& update, FeatureForm form, Writer& writer) {
  writer.Spread(update.points, kFullPointBytes, [&](auto points) {
    v1::FullMapPoints* proto = writer.part().mutable_points();
    WritePoints(points, writer.slots(), proto);
    if (form == FeatureForm::kPlain) return;
    // Points follow all keyframes: those of this part are the last ones.
    CodeDescriptors(points, DescriptorsOf(update.keyframes, writer.part().keyframes_size()), proto);
  });
}

// Writes what both messages of poses have: which keyframe, and where it is in the global frame.
template <typename Pose, typename Proto>
void WritePose(const Pose& pose, Writer& writer, Proto* proto) {
  writer.slots().Write(pose.id, proto->mutable_id());
  ToProto(pose.camera_from_global, proto->mutable_camera_from_global());
}

void WriteMoves(const std::vector<SharedKeyframeMove>& moves, Writer& writer) {
  for (const SharedKeyframeMove& move : moves) {
    writer.Reserve(kPoseBytes);
    WritePose(move, writer, writer.part().add_moved_keyframes());
  }
}

void WriteOwnPoses(const std::vector<OwnKeyframePose>& poses, Writer& writer) {
  for (const OwnKeyframePose& pose : poses) {
    writer.Reserve(2 * kPoseBytes);
    v1::OwnKeyframePose* proto = writer.part().add_own_keyframes();
    WritePose(pose, writer, proto);
    ToProto(pose.camera_from_local, proto->mutable_camera_from_local());
  }
}

void WriteLandmarks(const SharedUpdate& update, Writer& writer) {
  for (const Landmark& landmark : update.landmarks) {
    writer.Reserve((landmark.members.size() + 2) * kIdBytes);
    v1::Landmark* proto = writer.part().add_landmarks();
    writer.slots().Write(landmark.survivor, proto->mutable_survivor());
    WriteIds(std::span<const MapPointId>(landmark.members), writer.slots(),
             proto->mutable_members());
  }
}

absl::Status ReadCameras(const v1::SharedUpdate& proto, const SlotReader& slots,
                         CameraBook& cameras) {
  for (const v1::SharedCamera& entry : proto.cameras()) {
    ASSIGN_OR_RETURN(const LocalMapId local_map, slots.LocalMap(entry.slot()));
    ASSIGN_OR_RETURN(const Camera camera, FromProto(entry.camera()));
    RETURN_IF_ERROR(cameras.Add(local_map, entry.index(), std::make_shared<const Camera>(camera)));
  }
  return absl::OkStatus();
}

absl::Status ReadSightings(const v1::SharedKeyframe& proto, const SlotReader& slots,
                           std::vector<MapPointId>& points) {
  ASSIGN_OR_RETURN(const std::vector<MapPointId> seen, slots.Points(proto.points(), "points"));
  if (static_cast<int>(seen.size()) != proto.keypoint_deltas_size()) {
    return BadLength("keypoint_deltas", proto.keypoint_deltas_size(),
                     static_cast<int64_t>(seen.size()));
  }
  uint64_t keypoint = 0;
  for (size_t i = 0; i < seen.size(); ++i) {
    keypoint += proto.keypoint_deltas(static_cast<int>(i));
    if (keypoint >= points.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat("keypoint ", i, " is ", keypoint, " of ", points.size()));
    }
    points[keypoint] = seen[i];
  }
  return absl::OkStatus();
}

absl::StatusOr<SharedKeyframe> ReadKeyframe(const v1::SharedKeyframe& proto,
                                            const SlotReader& slots, const CameraBook& cameras) {
  SharedKeyframe keyframe;
  ASSIGN_OR_RETURN(const KeyframeId id, slots.Keyframe(proto.id()));
  if (!id.IsValid()) return absl::InvalidArgumentError("id is missing");
  ASSIGN_OR_RETURN(keyframe.payload, FromProto(proto.payload(), id, cameras));
  ASSIGN_OR_RETURN(keyframe.camera_from_global, FromProto(proto.camera_from_global()));
  if (proto.has_parent()) {
    ASSIGN_OR_RETURN(keyframe.parent, slots.Keyframe(proto.parent()));
  }
  keyframe.points.resize(keyframe.payload->features.keypoints.size());
  RETURN_IF_ERROR(Locate(ReadSightings(proto, slots, keyframe.points), ToString(id)));
  return keyframe;
}

// Reads what WritePose writes.
template <typename Proto, typename Pose>
absl::Status ReadPose(const Proto& proto, const SlotReader& slots, Pose& pose) {
  ASSIGN_OR_RETURN(pose.id, slots.Keyframe(proto.id()));
  if (!pose.id.IsValid()) return absl::InvalidArgumentError("a pose names no keyframe");
  ASSIGN_OR_RETURN(pose.camera_from_global, FromProto(proto.camera_from_global()));
  return absl::OkStatus();
}

absl::StatusOr<OwnKeyframePose> ReadOwnPose(const v1::OwnKeyframePose& proto,
                                            const SlotReader& slots) {
  OwnKeyframePose pose;
  RETURN_IF_ERROR(ReadPose(proto, slots, pose));
  auto camera_from_local = FromProto(proto.camera_from_local());
  if (!camera_from_local.ok()) {
    return Locate(camera_from_local.status(),
                  absl::StrCat(ToString(pose.id), ".camera_from_local"));
  }
  pose.camera_from_local = *camera_from_local;
  return pose;
}

absl::StatusOr<Landmark> ReadLandmark(const v1::Landmark& proto, const SlotReader& slots) {
  Landmark landmark;
  ASSIGN_OR_RETURN(landmark.survivor, slots.Point(proto.survivor()));
  if (!landmark.survivor.IsValid()) return absl::InvalidArgumentError("a landmark has no survivor");
  ASSIGN_OR_RETURN(landmark.members, slots.Points(proto.members(), "landmarks.members"));
  return landmark;
}

void Append(SharedUpdate& update, SharedUpdate& part) {
  update.revision = part.revision;
  update.restart |= part.restart;
  update.more_places = part.more_places;
  if (part.global_from_local.has_value()) update.global_from_local = part.global_from_local;
  update.apart |= part.apart;
  update.in_metres |= part.in_metres;
  if (part.local_map.IsValid()) update.local_map = part.local_map;
  AppendAll(update.keyframes, part.keyframes);
  AppendAll(update.points, part.points);
  AppendAll(update.moved_keyframes, part.moved_keyframes);
  AppendAll(update.moved_points, part.moved_points);
  AppendAll(update.observations, part.observations);
  AppendAll(update.landmarks, part.landmarks);
  AppendAll(update.own_keyframes, part.own_keyframes);
  AppendAll(update.removed_keyframes, part.removed_keyframes);
  AppendAll(update.removed_points, part.removed_points);
}

}  // namespace

std::vector<v1::SharedUpdate> ToProto(const SharedUpdate& update, CameraBook& sent,
                                      size_t part_bytes, FeatureForm form) {
  Writer writer(part_bytes, [&](v1::SharedUpdate& part) {
    part.set_revision(update.revision);
    part.set_continues(true);
    part.set_more_places(update.more_places);
    return SlotWriter(part.mutable_local_maps());
  });
  writer.part().set_restart(update.restart);
  if (update.global_from_local.has_value()) {
    ToProto(*update.global_from_local, writer.part().mutable_global_from_local());
  }
  writer.part().set_apart_from_global_frame(update.apart);
  writer.part().set_in_metres(update.in_metres);
  if (update.local_map.IsValid()) writer.part().set_local_map(update.local_map.value);
  for (const SharedKeyframe& keyframe : update.keyframes) {
    WriteKeyframe(keyframe, form, sent, writer);
  }
  WriteFullPoints(update, form, writer);
  WriteMoves(update.moved_keyframes, writer);
  writer.Spread(update.moved_points, kLightPointBytes, [&](auto points) {
    WritePoints(points, writer.slots(), writer.part().mutable_moved_points());
  });
  writer.Spread(update.observations, kObservationBytes, [&](auto changes) {
    WriteObservations(changes, writer.slots(), writer.part().mutable_observations());
  });
  WriteLandmarks(update, writer);
  WriteOwnPoses(update.own_keyframes, writer);
  writer.Spread(update.removed_keyframes, kIdBytes, [&](auto ids) {
    WriteIds(ids, writer.slots(), writer.part().mutable_removed_keyframes());
  });
  writer.Spread(update.removed_points, kIdBytes, [&](auto ids) {
    WriteIds(ids, writer.slots(), writer.part().mutable_removed_points());
  });
  writer.part().clear_continues();
  return std::move(writer).Take();
}

absl::StatusOr<SharedUpdate> FromProto(const v1::SharedUpdate& proto, CameraBook& cameras) {
  SharedUpdate update;
  update.revision = proto.revision();
  update.restart = proto.restart();
  update.more_places = proto.more_places();
  if (proto.has_global_from_local()) {
    const auto global_from_local = FromProto(proto.global_from_local());
    if (!global_from_local.ok()) return Locate(global_from_local.status(), "global_from_local");
    update.global_from_local = *global_from_local;
  }
  update.apart = proto.apart_from_global_frame();
  update.in_metres = proto.in_metres();
  update.local_map = LocalMapId{proto.local_map()};
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(proto.local_maps()));
  RETURN_IF_ERROR(ReadCameras(proto, slots, cameras));
  for (int i = 0; i < proto.keyframes_size(); ++i) {
    auto keyframe = ReadKeyframe(proto.keyframes(i), slots, cameras);
    if (!keyframe.ok()) return Locate(keyframe.status(), absl::StrCat("keyframes[", i, "]"));
    update.keyframes.push_back(*std::move(keyframe));
  }
  auto points = ReadSharedPoints(proto.points(), slots,
                                 DescriptorsOf(update.keyframes, proto.keyframes_size()));
  if (!points.ok()) return Locate(points.status(), "points");
  update.points = *std::move(points);
  for (const v1::SharedKeyframePose& entry : proto.moved_keyframes()) {
    RETURN_IF_ERROR(ReadPose(entry, slots, update.moved_keyframes.emplace_back()));
  }
  ASSIGN_OR_RETURN(update.moved_points, ReadMovedPoints(proto.moved_points(), slots));
  ASSIGN_OR_RETURN(update.observations, ReadObservations(proto.observations(), slots));
  for (const v1::Landmark& entry : proto.landmarks()) {
    ASSIGN_OR_RETURN(Landmark landmark, ReadLandmark(entry, slots));
    update.landmarks.push_back(std::move(landmark));
  }
  for (const v1::OwnKeyframePose& entry : proto.own_keyframes()) {
    ASSIGN_OR_RETURN(const OwnKeyframePose pose, ReadOwnPose(entry, slots));
    update.own_keyframes.push_back(pose);
  }
  ASSIGN_OR_RETURN(update.removed_keyframes,
                   slots.Keyframes(proto.removed_keyframes(), "removed_keyframes"));
  ASSIGN_OR_RETURN(update.removed_points, slots.Points(proto.removed_points(), "removed_points"));
  return update;
}

absl::StatusOr<std::optional<SharedUpdate>> SharedUpdateAssembler::Add(const v1::SharedUpdate& part,
                                                                       CameraBook& cameras) {
  bytes_ += part.ByteSizeLong();
  for (const v1::SharedKeyframe& keyframe : part.keyframes()) {
    const v1::Features& features = keyframe.payload().features();
    bytes_ += UncodedBytes(features) - features.ByteSizeLong();
  }
  if (bytes_ > kMaxUpdateBytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("a shared update is longer than ", kMaxUpdateBytes, " bytes"));
  }
  ASSIGN_OR_RETURN(SharedUpdate read, FromProto(part, cameras));
  if (started_) {
    Append(*started_, read);
  } else {
    started_ = std::move(read);
  }
  if (part.continues()) return std::nullopt;
  bytes_ = 0;
  return std::exchange(started_, std::nullopt);
}

namespace {

template <typename Message>
void AddCapabilities(const Capabilities& capabilities, Message* proto) {
  if (capabilities.points_follow) proto->add_capabilities(v1::CAPABILITY_POINTS_FOLLOW);
  if (capabilities.coded_features) proto->add_capabilities(v1::CAPABILITY_CODED_FEATURES);
  if (capabilities.localise_only) proto->add_capabilities(v1::CAPABILITY_LOCALISE_ONLY);
  if (capabilities.keeps_localised) proto->add_capabilities(v1::CAPABILITY_LOCALISED_KEPT);
  if (capabilities.keyframe_pictures) proto->add_capabilities(v1::CAPABILITY_KEYFRAME_PICTURES);
  if (capabilities.takes_reports) proto->add_capabilities(v1::CAPABILITY_AGENT_REPORTS);
}

// Ignores capabilities that it does not know: they are of a newer version.
template <typename Message>
Capabilities ReadCapabilities(const Message& proto) {
  Capabilities capabilities;
  for (const int capability : proto.capabilities()) {
    capabilities.points_follow |= capability == v1::CAPABILITY_POINTS_FOLLOW;
    capabilities.coded_features |= capability == v1::CAPABILITY_CODED_FEATURES;
    capabilities.localise_only |= capability == v1::CAPABILITY_LOCALISE_ONLY;
    capabilities.keeps_localised |= capability == v1::CAPABILITY_LOCALISED_KEPT;
    capabilities.keyframe_pictures |= capability == v1::CAPABILITY_KEYFRAME_PICTURES;
    capabilities.takes_reports |= capability == v1::CAPABILITY_AGENT_REPORTS;
  }
  return capabilities;
}

// The first entry of a mode is the one that is written.
constexpr std::pair<v1::Share, ShareMode> kShares[] = {
    {v1::SHARE_UNSPECIFIED, ShareMode::kEverything},
    {v1::SHARE_EVERYTHING, ShareMode::kEverything},
    {v1::SHARE_NEARBY, ShareMode::kNearby},
    {v1::SHARE_CORRECTIONS, ShareMode::kCorrections},
    {v1::SHARE_NONE, ShareMode::kNone},
};

v1::Share ToProto(ShareMode mode) {
  return std::ranges::find(kShares, mode, &std::pair<v1::Share, ShareMode>::second)->first;
}

absl::StatusOr<ShareMode> ReadShareMode(int share) {
  for (const auto& [proto, mode] : kShares) {
    if (proto == share) return mode;
  }
  return OutOfRange("share", share, v1::Share_MIN, v1::Share_MAX);
}

// A radius is checked whatever the mode is, and used with SHARE_NEARBY only.
absl::StatusOr<ShareScope> ReadShareScope(const v1::OpenSession& proto) {
  ShareScope scope;
  ASSIGN_OR_RETURN(scope.mode, ReadShareMode(proto.share()));
  const double radius_m = proto.share_radius_m();
  if (radius_m == 0) return scope;
  if (!kShareRadius_m.Contains(radius_m)) {
    return OutOfRange("share_radius_m", radius_m, kShareRadius_m.least, kShareRadius_m.most);
  }
  if (scope.mode == ShareMode::kNearby) scope.radius_m = radius_m;
  return scope;
}

}  // namespace

void ToProto(const SessionRequest& request, v1::OpenSession* proto) {
  proto->set_mission(MissionName(request.mission));
  proto->set_agent(request.agent);
  proto->set_last_revision(request.last_revision);
  for (const LocalMapId id : request.local_maps) proto->add_local_maps(id.value);
  proto->set_instance(request.instance);
  proto->set_take_over(request.take_over);
  AddCapabilities(request.capabilities, proto);
  proto->set_downlink_bytes_per_second(request.downlink_bytes_per_second);
  proto->set_share(ToProto(request.share.mode));
  if (request.share.mode == ShareMode::kNearby) proto->set_share_radius_m(request.share.radius_m);
  proto->set_localise_only(request.localise_only);
  proto->set_mission_uid(request.mission_uid);
}

absl::StatusOr<SessionRequest> FromProto(const v1::OpenSession& proto) {
  SessionRequest request;
  ASSIGN_OR_RETURN(request.mission, ParseMissionName(proto.mission()));
  RETURN_IF_ERROR(CheckNameSegment("agent", proto.agent()));
  request.agent = proto.agent();
  request.last_revision = proto.last_revision();
  if (proto.local_maps_size() > kMaxLocalMapsOfMessage) {
    return OutOfRange("number of local_maps", proto.local_maps_size(), 0, kMaxLocalMapsOfMessage);
  }
  for (const uint64_t value : proto.local_maps()) {
    if (value == 0) return absl::InvalidArgumentError("local_maps names 0");
    request.local_maps.push_back({value});
  }
  request.instance = proto.instance();
  request.take_over = proto.take_over();
  request.capabilities = ReadCapabilities(proto);
  request.downlink_bytes_per_second = proto.downlink_bytes_per_second();
  if (const uint64_t bound = request.downlink_bytes_per_second;
      bound != 0 && (bound < kMinDownlink_Bps || bound > kMaxDownlink_Bps)) {
    return OutOfRange("downlink_bytes_per_second", bound, kMinDownlink_Bps, kMaxDownlink_Bps);
  }
  ASSIGN_OR_RETURN(request.share, ReadShareScope(proto));
  request.localise_only = proto.localise_only();
  request.mission_uid = proto.mission_uid();
  if (request.localise_only && !request.local_maps.empty()) {
    return absl::InvalidArgumentError(
        "local_maps is not empty, though an agent with localise_only has none");
  }
  return request;
}

void ToProto(const Acknowledgement& acknowledgement, v1::Acknowledgement* proto) {
  proto->set_local_map(acknowledgement.local_map.value);
  proto->set_number(acknowledgement.number);
}

absl::StatusOr<Acknowledgement> FromProto(const v1::Acknowledgement& proto) {
  if (proto.local_map() == 0) return absl::InvalidArgumentError("acknowledgement.local_map is 0");
  return Acknowledgement{{proto.local_map()}, proto.number()};
}

void ToProto(const SessionGrant& grant, v1::SessionGrant* proto) {
  for (const Acknowledgement& entry : grant.acknowledged) {
    ToProto(entry, proto->add_acknowledged());
  }
  AddCapabilities(grant.capabilities, proto);
  proto->set_mission_uid(grant.mission_uid);
}

absl::StatusOr<SessionGrant> FromProto(const v1::SessionGrant& proto) {
  SessionGrant grant;
  for (const v1::Acknowledgement& entry : proto.acknowledged()) {
    ASSIGN_OR_RETURN(const Acknowledgement acknowledgement, FromProto(entry));
    grant.acknowledged.push_back(acknowledgement);
  }
  grant.capabilities = ReadCapabilities(proto);
  grant.mission_uid = proto.mission_uid();
  return grant;
}

}  // namespace corbslam::services

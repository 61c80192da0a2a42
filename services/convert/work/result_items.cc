#include "services/convert/work/result_items.h"

#include <string>
#include <utility>

#include "services/convert/errors.h"
#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/limits.h"
#include "services/convert/overlap.h"
#include "services/convert/parts.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kPoseBytes = 110;
constexpr size_t kPositionBytes = 36;
constexpr size_t kPairBytes = 24;
constexpr size_t kOverlapBytes = 160;

using Writer = PartWriter<v1::ResultChunk>;

void WritePoses(const ResultItems& items, Writer& writer) {
  for (const KeyframePose& pose : items.poses) {
    writer.Reserve(kPoseBytes);
    v1::ResultChunk::Pose* proto = writer.part().add_poses();
    writer.slots().Write(pose.id, proto->mutable_id());
    ToProto(pose.camera_from_map, proto->mutable_camera_from_map());
  }
}

void WriteColumns(const ResultItems& items, Writer& writer) {
  writer.Spread(items.positions, kPositionBytes, [&](auto positions) {
    IdColumnWriter ids(writer.slots(), writer.part().mutable_points());
    for (const PointPosition& position : positions) {
      ids.Add(position.id);
      for (const double value : position.position_in_map) writer.part().add_positions(value);
    }
  });
  writer.Spread(items.merges, kPairBytes, [&](auto merges) {
    IdColumnWriter survivors(writer.slots(), writer.part().mutable_merge_survivors());
    IdColumnWriter members(writer.slots(), writer.part().mutable_merge_members());
    for (const FuseMapsResult::Merge& merge : merges) {
      survivors.Add(merge.survivor);
      members.Add(merge.member);
    }
  });
  writer.Spread(items.rejected, kPairBytes, [&](auto rejected) {
    IdColumnWriter points(writer.slots(), writer.part().mutable_rejected_points());
    IdColumnWriter keyframes(writer.slots(), writer.part().mutable_rejected_keyframes());
    for (const RejectedObservation& observation : rejected) {
      points.Add(observation.point);
      keyframes.Add(observation.keyframe);
    }
  });
}

template <typename A, typename B, typename Pair>
absl::Status ReadPairs(const std::vector<A>& first, const std::vector<B>& second,
                       absl::string_view field, std::vector<Pair>& pairs) {
  if (first.size() != second.size()) {
    return BadLength(field, static_cast<int64_t>(second.size()),
                     static_cast<int64_t>(first.size()));
  }
  for (size_t i = 0; i < first.size(); ++i) pairs.push_back({first[i], second[i]});
  return absl::OkStatus();
}

absl::Status ReadPoses(const v1::ResultChunk& chunk, const SlotReader& slots, ResultItems& items) {
  for (const v1::ResultChunk::Pose& entry : chunk.poses()) {
    KeyframePose pose;
    ASSIGN_OR_RETURN(pose.id, slots.Keyframe(entry.id()));
    if (!pose.id.IsValid()) return absl::InvalidArgumentError("a pose names no keyframe");
    auto motion = FromProto(entry.camera_from_map());
    if (!motion.ok()) return Locate(motion.status(), absl::StrCat("pose of ", ToString(pose.id)));
    pose.camera_from_map = *motion;
    items.poses.push_back(pose);
  }
  return absl::OkStatus();
}

absl::Status ReadPositions(const v1::ResultChunk& chunk, const SlotReader& slots,
                           ResultItems& items) {
  ASSIGN_OR_RETURN(const std::vector<MapPointId> points, slots.Points(chunk.points(), "points"));
  if (chunk.positions_size() != 3 * static_cast<int64_t>(points.size())) {
    return BadLength("positions", chunk.positions_size(), 3 * static_cast<int64_t>(points.size()));
  }
  int at = 0;
  for (const MapPointId id : points) {
    const Eigen::Vector3d position(chunk.positions(at), chunk.positions(at + 1),
                                   chunk.positions(at + 2));
    at += 3;
    RETURN_IF_ERROR(Locate(CheckPosition(position), absl::StrCat("map point ", ToString(id))));
    items.positions.push_back({id, position});
  }
  return absl::OkStatus();
}

}  // namespace

bool WriteResultItems(const ResultItems& items, const ChunkSink& sink) {
  Writer writer(kChunkTargetBytes,
                [](v1::ResultChunk& chunk) { return SlotWriter(chunk.mutable_local_maps()); });
  WritePoses(items, writer);
  WriteColumns(items, writer);
  for (const Overlap& overlap : items.overlaps) {
    writer.Reserve(kOverlapBytes + overlap.inliers.size() * kPairBytes);
    ToProto(overlap, writer.slots(), writer.part().add_overlaps());
  }
  for (const v1::ResultChunk& chunk : std::move(writer).Take()) {
    std::string data = chunk.SerializeAsString();
    if (!data.empty() && !sink(std::move(data))) return false;
  }
  return true;
}

absl::Status ReadResultChunk(const v1::ResultChunk& chunk, ResultItems& items) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(chunk.local_maps()));
  RETURN_IF_ERROR(ReadPoses(chunk, slots, items));
  RETURN_IF_ERROR(ReadPositions(chunk, slots, items));
  ASSIGN_OR_RETURN(const auto survivors, slots.Points(chunk.merge_survivors(), "merge_survivors"));
  ASSIGN_OR_RETURN(const auto members, slots.Points(chunk.merge_members(), "merge_members"));
  RETURN_IF_ERROR(ReadPairs(survivors, members, "merge_members", items.merges));
  ASSIGN_OR_RETURN(const auto points, slots.Points(chunk.rejected_points(), "rejected_points"));
  ASSIGN_OR_RETURN(const auto keyframes,
                   slots.Keyframes(chunk.rejected_keyframes(), "rejected_keyframes"));
  RETURN_IF_ERROR(ReadPairs(points, keyframes, "rejected_keyframes", items.rejected));
  for (const v1::VerifiedOverlap& entry : chunk.overlaps()) {
    ASSIGN_OR_RETURN(Overlap overlap, FromProto(entry, slots));
    items.overlaps.push_back(std::move(overlap));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::services

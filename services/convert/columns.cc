#include "services/convert/columns.h"

#include <cmath>
#include <string>
#include <utility>

#include "services/convert/errors.h"
#include "services/convert/features.h"
#include "services/convert/geometry.h"
#include "services/convert/limits.h"
#include "slam/coding/sourced_descriptors.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr double kNormalSteps = 8191;

// Returns the position: the same columns carry points in a local frame and in the global one.
const Eigen::Vector3d& Position(const FullMapPoint& p) { return p.position_in_local; }
const Eigen::Vector3d& Position(const SharedMapPoint& p) { return p.position_in_global; }
const Eigen::Vector3d& Position(const LightMapPoint& p) { return p.position_in_local; }
const Eigen::Vector3d& Position(const SharedMapPointMove& p) { return p.position_in_global; }
const Eigen::Vector3d& Normal(const FullMapPoint& p) { return p.normal_in_local; }
const Eigen::Vector3d& Normal(const SharedMapPoint& p) { return p.normal_in_global; }
void SetPlace(FullMapPoint& p, const Eigen::Vector3d& position, const Eigen::Vector3d& normal) {
  p.position_in_local = position;
  p.normal_in_local = normal;
}
void SetPlace(SharedMapPoint& p, const Eigen::Vector3d& position, const Eigen::Vector3d& normal) {
  p.position_in_global = position;
  p.normal_in_global = normal;
}
void SetPlace(LightMapPoint& p, const Eigen::Vector3d& position) { p.position_in_local = position; }
void SetPlace(SharedMapPointMove& p, const Eigen::Vector3d& position) {
  p.position_in_global = position;
}

template <typename Point, typename Proto>
void WritePlaces(std::span<const Point> points, SlotWriter& slots, Proto* proto) {
  IdColumnWriter ids(slots, proto->mutable_ids());
  proto->mutable_positions()->Reserve(static_cast<int>(3 * points.size()));
  for (const Point& point : points) {
    ids.Add(point.id);
    for (const double value : Position(point)) proto->add_positions(static_cast<float>(value));
  }
}

template <typename Point>
void WriteFull(std::span<const Point> points, SlotWriter& slots, v1::FullMapPoints* proto) {
  WritePlaces(points, slots, proto);
  IdColumnWriter references(slots, proto->mutable_references());
  std::string& descriptors = *proto->mutable_descriptors();
  descriptors.reserve(points.size() * sizeof(Descriptor));
  for (const Point& point : points) {
    references.Add(point.reference);
    AppendDescriptor(point.descriptor, &descriptors);
    for (const double value : Normal(point)) {
      proto->add_normals_8191(static_cast<int32_t>(std::lround(value * kNormalSteps)));
    }
    proto->add_min_distances(static_cast<float>(point.min_distance));
    // Rounding must not make the largest distance less than the least one.
    proto->add_max_distances(
        std::max(static_cast<float>(point.max_distance), static_cast<float>(point.min_distance)));
  }
}

Eigen::Vector3d ReadVector(const google::protobuf::RepeatedField<float>& column, int i) {
  return {column[3 * i], column[3 * i + 1], column[3 * i + 2]};
}

absl::Status CheckFullLengths(const v1::FullMapPoints& proto) {
  const int64_t count = proto.ids().index_deltas_size();
  if (proto.positions_size() != 3 * count) {
    return BadLength("positions", proto.positions_size(), 3 * count);
  }
  if (proto.references().index_deltas_size() != count) {
    return BadLength("references", proto.references().index_deltas_size(), count);
  }
  const auto descriptor_bytes = static_cast<int64_t>(proto.descriptors().size());
  const int64_t expected_bytes = proto.coded_descriptors().empty() ? 32 * count : 0;
  if (descriptor_bytes != expected_bytes) {
    return BadLength("descriptors", descriptor_bytes, expected_bytes);
  }
  if (proto.normals_8191_size() != 3 * count) {
    return BadLength("normals_8191", proto.normals_8191_size(), 3 * count);
  }
  if (proto.min_distances_size() != count) {
    return BadLength("min_distances", proto.min_distances_size(), count);
  }
  if (proto.max_distances_size() != count) {
    return BadLength("max_distances", proto.max_distances_size(), count);
  }
  return absl::OkStatus();
}

absl::Status CheckDistances(double nearest, double farthest) {
  if (std::isfinite(nearest) && std::isfinite(farthest) && nearest >= 0 && farthest >= nearest) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat("distances are ", nearest, " to ", farthest,
                                                 ", must be finite, at least 0 and in order"));
}

template <typename Point>
absl::Status ReadGeometry(const v1::FullMapPoints& proto, int i, Point& point) {
  const Eigen::Vector3d position = ReadVector(proto.positions(), i);
  RETURN_IF_ERROR(CheckPosition(position));
  const Eigen::Vector3d steps(proto.normals_8191(3 * i), proto.normals_8191(3 * i + 1),
                              proto.normals_8191(3 * i + 2));
  ASSIGN_OR_RETURN(const Eigen::Vector3d normal, CheckNormal(steps / kNormalSteps));
  SetPlace(point, position, normal);
  point.min_distance = proto.min_distances(i);
  point.max_distance = proto.max_distances(i);
  return CheckDistances(point.min_distance, point.max_distance);
}

// Returns the descriptors that each point may be a copy of: those of its reference keyframe, where
// that is in the message.
std::vector<std::span<const Descriptor>> SourcesOf(std::span<const KeyframeId> references,
                                                   const KeyframeDescriptors& known) {
  std::vector<std::span<const Descriptor>> sources;
  sources.reserve(references.size());
  for (const KeyframeId& reference : references) {
    const auto it = known.find(reference);
    sources.push_back(it == known.end() ? std::span<const Descriptor>() : it->second);
  }
  return sources;
}

template <typename Point>
void CodeAgainst(std::span<const Point> points, const KeyframeDescriptors& known,
                 v1::FullMapPoints* proto) {
  std::vector<Descriptor> descriptors;
  std::vector<KeyframeId> references;
  for (const Point& point : points) {
    descriptors.push_back(point.descriptor);
    references.push_back(point.reference);
  }
  std::string coded = EncodeSourced(descriptors, SourcesOf(references, known));
  if (coded.size() >= proto->descriptors().size()) return;
  proto->set_coded_descriptors(std::move(coded));
  proto->clear_descriptors();
}

absl::StatusOr<std::vector<Descriptor>> ReadDescriptors(const v1::FullMapPoints& proto,
                                                        std::span<const KeyframeId> references,
                                                        const KeyframeDescriptors& known) {
  if (!proto.coded_descriptors().empty()) {
    return DecodeSourced(proto.coded_descriptors(), SourcesOf(references, known));
  }
  std::vector<Descriptor> descriptors(references.size());
  for (size_t i = 0; i < descriptors.size(); ++i) {
    descriptors[i] = DescriptorFromBytes(proto.descriptors(), i);
  }
  return descriptors;
}

template <typename Point>
absl::StatusOr<std::vector<Point>> ReadFull(const v1::FullMapPoints& proto, const SlotReader& slots,
                                            const KeyframeDescriptors& known) {
  RETURN_IF_ERROR(CheckFullLengths(proto));
  ASSIGN_OR_RETURN(const std::vector<MapPointId> ids, slots.Points(proto.ids(), "ids"));
  ASSIGN_OR_RETURN(const std::vector<KeyframeId> references,
                   slots.Keyframes(proto.references(), "references", /*may_be_none=*/true));
  ASSIGN_OR_RETURN(const std::vector<Descriptor> descriptors,
                   ReadDescriptors(proto, references, known));
  std::vector<Point> points(ids.size());
  for (size_t i = 0; i < ids.size(); ++i) {
    points[i].id = ids[i];
    points[i].reference = references[i];
    points[i].descriptor = descriptors[i];
    RETURN_IF_ERROR(Locate(ReadGeometry(proto, static_cast<int>(i), points[i]),
                           absl::StrCat("map point ", ToString(ids[i]))));
  }
  return points;
}

template <typename Point>
absl::StatusOr<std::vector<Point>> ReadPlaces(const v1::LightMapPoints& proto,
                                              const SlotReader& slots) {
  const int64_t count = proto.ids().index_deltas_size();
  if (proto.positions_size() != 3 * count) {
    return BadLength("positions", proto.positions_size(), 3 * count);
  }
  ASSIGN_OR_RETURN(const std::vector<MapPointId> ids, slots.Points(proto.ids(), "ids"));
  std::vector<Point> points(ids.size());
  for (size_t i = 0; i < ids.size(); ++i) {
    const Eigen::Vector3d position = ReadVector(proto.positions(), static_cast<int>(i));
    RETURN_IF_ERROR(Locate(CheckPosition(position), absl::StrCat("map point ", ToString(ids[i]))));
    points[i].id = ids[i];
    SetPlace(points[i], position);
  }
  return points;
}

absl::StatusOr<Rigid3d> ReadFrameMotion(const v1::TrackedFrames& proto, int i) {
  const auto value = [&](int k) { return double{proto.reference_from_camera(7 * i + k)}; };
  Rigid3d motion;
  ASSIGN_OR_RETURN(motion.rotation, CheckRotation(value(0), value(1), value(2), value(3)));
  motion.translation = {value(4), value(5), value(6)};
  RETURN_IF_ERROR(CheckPosition(motion.translation));
  return motion;
}

}  // namespace

absl::StatusOr<Eigen::Vector3d> CheckNormal(const Eigen::Vector3d& normal) {
  if (normal.isZero(0)) return normal;
  const double length = normal.norm();
  // The condition is written so that NaN fails.
  if (!(std::abs(length - 1) <= kNormalTolerance)) {
    return OutOfRange("length of the normal", length, 1 - kNormalTolerance, 1 + kNormalTolerance);
  }
  return Eigen::Vector3d(normal / length);
}

void CodeDescriptors(std::span<const FullMapPoint> points, const KeyframeDescriptors& known,
                     v1::FullMapPoints* proto) {
  CodeAgainst(points, known, proto);
}
void CodeDescriptors(std::span<const SharedMapPoint> points, const KeyframeDescriptors& known,
                     v1::FullMapPoints* proto) {
  CodeAgainst(points, known, proto);
}

void WritePoints(std::span<const FullMapPoint> points, SlotWriter& slots,
                 v1::FullMapPoints* proto) {
  WriteFull(points, slots, proto);
}
void WritePoints(std::span<const SharedMapPoint> points, SlotWriter& slots,
                 v1::FullMapPoints* proto) {
  WriteFull(points, slots, proto);
}
void WritePoints(std::span<const LightMapPoint> points, SlotWriter& slots,
                 v1::LightMapPoints* proto) {
  WritePlaces(points, slots, proto);
}
void WritePoints(std::span<const SharedMapPointMove> points, SlotWriter& slots,
                 v1::LightMapPoints* proto) {
  WritePlaces(points, slots, proto);
}

void WriteObservations(std::span<const ObservationChange> changes, SlotWriter& slots,
                       v1::ObservationChanges* proto) {
  IdColumnWriter points(slots, proto->mutable_points());
  IdColumnWriter keyframes(slots, proto->mutable_keyframes());
  for (const ObservationChange& change : changes) {
    const bool removed = change.kind == ObservationChange::Kind::kRemoved;
    // The column of kinds begins with the first removal.
    if (removed && proto->kinds_size() == 0) {
      proto->mutable_kinds()->Resize(proto->keypoints_size(), v1::ObservationChanges::KIND_ADDED);
    }
    if (removed || proto->kinds_size() > 0) {
      proto->add_kinds(removed ? v1::ObservationChanges::KIND_REMOVED
                               : v1::ObservationChanges::KIND_ADDED);
    }
    points.Add(change.point);
    keyframes.Add(change.keyframe);
    proto->add_keypoints(change.keypoint);
  }
}

void WriteFrames(std::span<const TrackedFrame> frames, SlotWriter& slots,
                 v1::TrackedFrames* proto) {
  IdColumnWriter references(slots, proto->mutable_references());
  int64_t last_ns = 0;
  for (const TrackedFrame& frame : frames) {
    proto->add_timestamp_deltas_ns(frame.timestamp_ns - last_ns);
    last_ns = frame.timestamp_ns;
    references.Add(frame.reference);
    const Eigen::Quaterniond& q = frame.reference_from_camera.rotation;
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) {
      proto->add_reference_from_camera(static_cast<float>(value));
    }
    for (const double value : frame.reference_from_camera.translation) {
      proto->add_reference_from_camera(static_cast<float>(value));
    }
  }
}

void WriteTimes(std::span<const int64_t> times_ns, TimeColumn* proto) {
  int64_t last_ns = 0;
  for (const int64_t time_ns : times_ns) {
    proto->Add(time_ns - last_ns);
    last_ns = time_ns;
  }
}

absl::StatusOr<std::vector<FullMapPoint>> ReadFullPoints(const v1::FullMapPoints& proto,
                                                         const SlotReader& slots,
                                                         const KeyframeDescriptors& known) {
  return ReadFull<FullMapPoint>(proto, slots, known);
}
absl::StatusOr<std::vector<SharedMapPoint>> ReadSharedPoints(const v1::FullMapPoints& proto,
                                                             const SlotReader& slots,
                                                             const KeyframeDescriptors& known) {
  return ReadFull<SharedMapPoint>(proto, slots, known);
}
absl::StatusOr<std::vector<LightMapPoint>> ReadLightPoints(const v1::LightMapPoints& proto,
                                                           const SlotReader& slots) {
  return ReadPlaces<LightMapPoint>(proto, slots);
}
absl::StatusOr<std::vector<SharedMapPointMove>> ReadMovedPoints(const v1::LightMapPoints& proto,
                                                                const SlotReader& slots) {
  return ReadPlaces<SharedMapPointMove>(proto, slots);
}

absl::StatusOr<std::vector<ObservationChange>> ReadObservations(const v1::ObservationChanges& proto,
                                                                const SlotReader& slots) {
  const int count = proto.keypoints_size();
  if (proto.kinds_size() != 0 && proto.kinds_size() != count) {
    return BadLength("kinds", proto.kinds_size(), count);
  }
  ASSIGN_OR_RETURN(const std::vector<MapPointId> points, slots.Points(proto.points(), "points"));
  ASSIGN_OR_RETURN(const std::vector<KeyframeId> keyframes,
                   slots.Keyframes(proto.keyframes(), "keyframes"));
  const auto size = static_cast<size_t>(count);
  if (points.size() != size) return BadLength("points", proto.points().index_deltas_size(), count);
  if (keyframes.size() != size) {
    return BadLength("keyframes", proto.keyframes().index_deltas_size(), count);
  }
  std::vector<ObservationChange> changes(size);
  for (int i = 0; i < count; ++i) {
    ObservationChange& change = changes[static_cast<size_t>(i)];
    const int kind = proto.kinds_size() == 0 ? v1::ObservationChanges::KIND_ADDED : proto.kinds(i);
    if (kind != v1::ObservationChanges::KIND_ADDED &&
        kind != v1::ObservationChanges::KIND_REMOVED) {
      return OutOfRange(absl::StrCat("kinds[", i, "]"), kind, 1, 2);
    }
    change.kind = kind == v1::ObservationChanges::KIND_ADDED ? ObservationChange::Kind::kAdded
                                                             : ObservationChange::Kind::kRemoved;
    change.point = points[static_cast<size_t>(i)];
    change.keyframe = keyframes[static_cast<size_t>(i)];
    change.keypoint = proto.keypoints(i);
    if (change.keypoint >= kMaxKeypoints) {
      return OutOfRange(absl::StrCat("keypoints[", i, "] of keyframe ", ToString(change.keyframe)),
                        change.keypoint, 0, kMaxKeypoints - 1);
    }
  }
  return changes;
}

absl::StatusOr<std::vector<TrackedFrame>> ReadFrames(const v1::TrackedFrames& proto,
                                                     const SlotReader& slots) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> times,
                   ReadTimes(proto.timestamp_deltas_ns(), "timestamp_deltas_ns"));
  ASSIGN_OR_RETURN(const std::vector<KeyframeId> references,
                   slots.Keyframes(proto.references(), "references"));
  const auto count = static_cast<int64_t>(times.size());
  if (references.size() != times.size()) {
    return BadLength("references", static_cast<int64_t>(references.size()), count);
  }
  if (proto.reference_from_camera_size() != 7 * count) {
    return BadLength("reference_from_camera", proto.reference_from_camera_size(), 7 * count);
  }
  std::vector<TrackedFrame> frames(times.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    auto motion = ReadFrameMotion(proto, static_cast<int>(i));
    if (!motion.ok()) return Locate(motion.status(), absl::StrCat("frame at ", times[i], " ns"));
    frames[i] = {times[i], references[i], *motion};
  }
  return frames;
}

absl::StatusOr<std::vector<int64_t>> ReadTimes(const TimeColumn& proto, absl::string_view field) {
  std::vector<int64_t> times;
  times.reserve(static_cast<size_t>(proto.size()));
  int64_t time_ns = 0;
  for (int i = 0; i < proto.size(); ++i) {
    const int64_t delta_ns = proto[i];
    // The time so far is between 0 and the limit, so that neither difference nor sum can overflow.
    const int64_t largest_ns = kMaxTimestamp_ns - time_ns;
    if (delta_ns < -kMaxTimestamp_ns || delta_ns > largest_ns) {
      return OutOfRange(absl::StrCat(field, "[", i, "]"), delta_ns, -kMaxTimestamp_ns, largest_ns);
    }
    time_ns += delta_ns;
    RETURN_IF_ERROR(Locate(CheckTimestamp(time_ns), absl::StrCat(field, "[", i, "]")));
    times.push_back(time_ns);
  }
  return times;
}

}  // namespace corbslam::services
